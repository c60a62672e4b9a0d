"""A small explicit material point method for a column of soil and pore water: linear hat functions, update stress last.

Run as: python mpm.py CASE.json OUT_DIR REFINEMENT. Points carry speed, effective stress and pore pressure; nodes carry
the motion of soil and Darcy's velocity of its water (u-p form). Points move among the nodes at large strain only. Cases
without inertia run with a density so small, or so large, that inertia is a thousandth of the load when first asked for.
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from protocol import Case, unable, write  # noqa: E402

PER_CELL, MAX_STEPS = 2, 1_500_000  # about a minute; a third of that many at large strain
WAVE, FLOW, DELAY = 0.7, 0.9, 0.001  # parts of h/c (stable to 0.75) and h^2/2D; inertia let in where a case has none


def loads(case):
    return [*case.given.get("loads", []), *([case.given["surcharge"]] if "surcharge" in case.given else [])]


def check(case):
    """Refuses what is not solved here."""
    get, given, drains = case.get, case.given, [stage.get("drained", "none") for stage in case.given.get("stages", [])]
    soils = [given.get("soil", {}), *given.get("layers", []), given.get("water") or {}]
    refused = {
        "it is not a column": get("dimension") != "column",
        "it asks for " + ", ".join(case.wanted): list(case.wanted) not in (["settlement"], ["pore_pressure"]),
        "free surfaces, feeds, wells, plates": any(get(key) for key in ("water.free_surface", "wells", "plates")),
        "the water is incompressible, which no explicit step follows": get("water.bulk_modulus_pa") == np.inf,
        "soil that is not linear elastic": any("linear_elastic" not in s.get("law", ["linear_elastic"]) for s in soils),
        "a conductivity that changes": any(s.get("kozeny_carman") or s.get("anisotropy", 1) != 1 for s in soils),
        "its start": get("start") not in ("unloaded", "undrained-equilibrium", "given"),
        "its boundaries": get("boundaries.bottom") == "free" or get("boundaries.top") != "free" or any(
            set(ends) - {"top", "bottom"} for ends in drains if ends != "none"),
        "its loads": any(q["on"] not in ("top", "surface") or {*q} & {"strip", "sine", "wave", "water"}
                         for q in loads(case)),
        "statics of dry soil": "water" not in given and not case.json["physics"]["inertia"],
    }
    if any(refused.values()):
        unable(case, "; ".join(why for why, true in refused.items() if true))


class Column:
    """Points with their soil, and the state that they carry."""

    def __init__(self, case):
        get, wet = case.get, "water" in case.given
        self.height, self.cell, self.gravity = get("geometry.column.height_m"), case.cell, get("gravity_m_s2", 0.0)
        self.large, self.nodes = case.json["physics"]["strain"] == "large", round(self.height / self.cell) + 1
        self.length = self.cell / PER_CELL
        self.start = (np.arange((self.nodes - 1) * PER_CELL) + 0.5) * self.length
        layers = case.given.get("layers") or [{**case.given["soil"], "up_to_m": self.height}]
        soils = [{**soil, **soil["law"]["linear_elastic"]} for soil in layers]
        at = np.searchsorted([soil["up_to_m"] for soil in soils], self.start)
        pick = lambda key, default=None: np.array([soil.get(key, default) for soil in soils], float)[at]  # noqa: E731
        young, poisson, porosity = pick("youngs_modulus_pa"), pick("poisson_ratio"), pick("porosity")
        biot, self.water_density = pick("biot_coefficient", 1.0), get("water.density_kg_m3", 0.0)
        self.modulus, self.biot = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)), biot * wet
        self.density = (1 - porosity) * pick("grain_density_kg_m3") + porosity * self.water_density
        grains = (biot - porosity) / pick("grain_bulk_modulus_pa", np.inf)
        self.water = wet / (porosity / get("water.bulk_modulus_pa", 1.0) + grains)  # pressure per volume of water
        flow = "hydraulic_conductivity_m_s"
        self.mobility = pick(flow, get("water." + flow, 0.0)) / get("water.unit_weight_n_m3", 1.0) + 1e-30
        self.undrained = self.modulus + self.biot**2 * self.water
        tables = [(q["pressure_pa"], *np.transpose(q.get("times") or [[0, 0], [q.get("ramp_time_s") or 1e-30, 1]]))
                  for q in loads(case)]
        self.load = lambda time: 0.0 * time + sum(q * np.interp(time, at, part) for q, at, part in tables)
        self.stress, self.pressure = (np.interp(self.start, *np.transpose(get("initial." + key, [[0.0, 0.0]])))
                                      for key in ("stress_yy_pa", "pressure_pa"))
        self.strain, self.speed = np.zeros((2, len(self.start)))  # from a given start they count from there
        if get("start") == "undrained-equilibrium":
            weight = self.density * self.gravity * self.length
            self.strain = -(self.load(1e-20) + np.cumsum(weight[::-1])[::-1] - weight / 2) / self.undrained
            self.stress, self.pressure = self.modulus * self.strain, -self.biot * self.water * self.strain
        self.moved = self.length * (np.cumsum(self.strain) - self.strain / 2)

    def step(self, case):
        """The longest stable step, and the factor on the density: 1 where inertia counts."""
        flow, factor = self.cell**2 / (2 * (self.mobility * self.water).max() + 1e-300), 1.0
        if not case.json["physics"]["inertia"] and not case.get("stages.0.damping_per_s"):
            # a surface that settles as sqrt(D t) needs about 0.28 rho H sqrt(D) / (M t^1.5) of its load to speed up
            first = min(t for wanted in case.wanted.values() for t in wanted["times_s"] if t > 0)
            diffusion = (self.mobility / (1 / self.modulus + 1 / self.water)).max()
            dense = DELAY * self.modulus.min() * first**1.5 / (0.28 * self.height * diffusion**0.5)
            factor = min(dense, (self.undrained * (3 * flow / self.cell) ** 2).min()) / self.density.max()
        wave = self.cell / np.sqrt(self.undrained / (factor * self.density)).max()
        return 1 / (1 / (WAVE * wave) + 1 / (FLOW * flow)), factor

    def shapes(self):
        """Hat functions of the nodes at the points, their slopes, and the lengths of the points."""
        place = (self.start + self.moved if self.large else self.start) / self.cell
        left, point = np.clip(place.astype(int), 0, self.nodes - 2), np.arange(len(place))
        hat, slope = np.zeros((2, len(place), self.nodes))
        hat[point, left], hat[point, left + 1] = left + 1 - place, place - left
        slope[point, left], slope[point, left + 1] = -1 / self.cell, 1 / self.cell
        return hat, slope, self.length * (np.exp(self.strain) if self.large else 1 + 0 * place)

    def advance(self, stage, begin, end, count, factor):
        """Equal steps from one time to the next."""
        dt, damping = (end - begin) / max(count, 1), stage.get("damping_per_s", 0.0)
        drained, slow = stage.get("drained", "none"), (np.arange(self.nodes) > 0) / (1 + damping * dt)  # a firm base
        wet = np.r_["bottom" in drained, np.ones(self.nodes - 2), "top" in drained]
        mass, load = factor * self.density * self.length, self.load(begin + (np.arange(count) + 0.5) * dt)
        for n in range(count):
            if n == 0 or self.large:
                hat, slope, length = self.shapes()
                lump = np.maximum(hat.T @ mass, 1e-6 * mass.max())
                body, push = hat.T * mass / lump[:, None], slope.T * length * (dt / lump)[:, None]
                fall, tip = dt * self.gravity / factor, np.eye(self.nodes)[-1] * dt / lump
                ease = wet / np.maximum(hat.T @ (length / self.mobility), 1e-30)
                seep, drift = slope.T * length * ease[:, None], self.water_density * (hat.T @ length) * ease
            old = body @ self.speed
            new = (old + push @ (self.biot * self.pressure - self.stress) - fall - load[n] * tip) * slow
            gain = new - old
            flow = seep @ self.pressure - drift * (factor / dt * gain + self.gravity)
            strain = slope @ (dt * new)
            self.speed += hat @ gain
            self.moved += hat @ (dt * new)
            self.strain, self.stress = self.strain + strain, self.stress + self.modulus * strain
            self.pressure -= self.water * (self.biot * strain + slope @ (dt * flow))

    def read(self, quantity, time):
        """The mean pressure of each cell, or how far the surface is down: the last point and the rest of its way."""
        if quantity == "pore_pressure":
            means = [value.reshape(-1, PER_CELL).mean(axis=1) for value in (self.start, self.pressure)]
            return [(quantity, time, None, y, p) for y, p in zip(*means)]
        return [(quantity, time, None, None, -self.moved[-1] - np.expm1(self.strain[-1]) * self.length / 2)]


def main(path, folder, refinement):
    check(case := Case(path, refinement))
    column, stages, rows, begun, steps = Column(case), case.given["stages"], [], 0.0, 0
    step, factor = column.step(case)
    if sum(stage["until"]["time_s"] for stage in stages) / step > MAX_STEPS / (3 if column.large else 1):
        unable(case, f"too many explicit steps at refinement {refinement}")
    for stage in stages:
        wanted = [(t, quantity) for quantity, w in case.wanted.items() for t in w["times_s"] if stage is stages[-1]]
        now = 0.0
        for time, quantity in sorted(wanted) + [(stage["until"]["time_s"], None)]:
            count = int(np.ceil((time - now) / step))
            column.advance(stage, begun + now, begun + time, count, factor)
            now, steps, rows = time, steps + count, rows + (column.read(quantity, time) if quantity else [])
        begun += now
    write(folder, case, rows, "student-mpm", "1", {"steps": steps, "points": PER_CELL, "density_factor": factor})


main(*sys.argv[1:])

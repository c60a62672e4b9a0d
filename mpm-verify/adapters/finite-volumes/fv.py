"""One-dimensional finite volumes for columns of soil: consolidation at small and large strain, Richards' equation.

    python fv.py CASE.json OUT_DIR REFINEMENT

The unknown is the pore pressure at the centres of cells that are fixed in the soil. Total stress follows from loads and
weight, strain from total stress less pressure, and the water in a cell changes by two-point fluxes alone. Steps in time
are those of the L-stable diagonally implicit Runge-Kutta method of second order (Alexander 1977).
"""

import pathlib
import sys

import numpy as np
import scipy
from scipy.linalg import solve_banded

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from protocol import Case, unable, write

GAMMA = 1 - np.sqrt(0.5)
GROWTH = 0.04  # a step over the time since the last sudden change

# What this code knows, by the place in the case: any other key is refused.
KNOWN = {
    "": "boundaries dimension geometry gravity_m_s2 initial layers loads soil stages start surcharge water wells",
    "layers": "anisotropy bedding_angle_deg grain_density_kg_m3 hydraulic_conductivity_m_s kozeny_carman law porosity "
              "up_to_m",
    "loads": "on pressure_pa ramp_time_s times",
    "soil": "biot_coefficient grain_bulk_modulus_pa grain_density_kg_m3 law porosity",
    "stages": "damping_per_s drained until",  # damping is one of inertia, which is left out
    "surcharge": "on pressure_pa ramp_time_s",
    "water": "bulk_modulus_pa density_kg_m3 free_surface hydraulic_conductivity_m_s kozeny_carman unit_weight_n_m3",
    "water.free_surface": "feed level_m retention saturation suction_m",
    "water.free_surface.feed": "bottom top",
    **dict.fromkeys(("water.free_surface.feed.bottom", "water.free_surface.feed.top"), "head_m times velocity_m_s"),
    "wells": "at_m rate_m3_s",
}


def refuse(case):
    """Ends where the case is not one of a column that this code can solve."""
    start, free, large = case.get("start"), case.get("water.free_surface"), case.json["physics"]["strain"] == "large"
    sides = [case.get(f"boundaries.{side}") for side in ("left", "right", "top")]
    changing = any(len(course(load)[0]) > 1 for load in loads(case))
    answered = {"pore_pressure", "effective_saturation" if free else "settlement"}
    for hinders, why in (
        (case.get("dimension") != "column", "only columns are one-dimensional"),
        (case.json["physics"]["inertia"], "there is no inertia in this code"),
        (not case.get("water"), "dry soil has no pore pressure"),
        (sides != ["roller", "roller", "free"], "only a column between rollers with a free top"),
        (case.get("boundaries.bottom") not in ("roller", "fixed"), "the base must be at rest"),
        (any(load["on"] not in ("top", "surface") for load in loads(case)), "loads are on the top only"),
        (start not in ("unloaded", "undrained-equilibrium", "given"), "no such start"),
        (start != "unloaded" and changing, "a load that changes needs an unloaded start"),
        (free and list(free.get("retention", {})) != ["gardner"], "a free surface needs the retention of Gardner"),
        (free and (large or loads(case) or start != "unloaded"), "unsaturated soil is rigid and without loads"),
        (free and (case.get("wells") or not case.get("gravity_m_s2")), "unsaturated soil has weight and no wells"),
        (large and (start == "given" or case.get("soil.biot_coefficient")), "no such start or grains at large strain"),
        (set(case.wanted) - answered, f"no {', '.join(set(case.wanted) - answered)}"),
    ):
        if hinders:
            unable(case, why)
    for place, known in KNOWN.items():
        tables = case.get(place) if place else case.given
        for table in tables if isinstance(tables, list) else [tables or {}]:
            for key in set(table) - set(known.split()):
                unable(case, f"unknown key {place}.{key}")


def loads(case):
    """Loads on the top, the surcharge among them."""
    return case.get("loads", []) + ([case.get("surcharge")] if case.get("surcharge") else [])


def course(table):
    """Times and factors of a load or a feed, constant before and after."""
    ramp = table.get("ramp_time_s", 0.0)
    return np.array(table.get("times") or ([[0.0, 0.0], [ramp, 1.0]] if ramp else [[0.0, 1.0]])).T


class Column:
    """Cells, their soil, and how much water they hold and pass on."""

    def __init__(self, case):
        self.case, self.loads = case, loads(case)
        self.large, self.unsaturated = case.json["physics"]["strain"] == "large", bool(case.get("water.free_surface"))
        self.unit_weight, self.bulk = case.get("water.unit_weight_n_m3"), case.get("water.bulk_modulus_pa")
        self.alpha, gravity = case.get("soil.biot_coefficient", 1.0), case.get("gravity_m_s2", 0.0)
        self.feed = case.get("water.free_surface.feed", {})
        self.cells(case, case.get("geometry.column.height_m"))
        self.storage = self.porosity / self.bulk
        self.storage += (self.alpha - self.porosity) / case.get("soil.grain_bulk_modulus_pa", np.inf)
        self.pull = case.get("water.density_kg_m3") * gravity
        weight = self.size * ((1 - self.porosity) * self.grains * gravity + self.porosity * self.pull)
        self.weight = np.cumsum(weight[::-1])[::-1] - weight / 2
        self.decay = case.get("water.free_surface.retention.gardner.alpha_per_m", 0.0) / self.unit_weight
        self.mobile = self.porosity * (1 - case.get("water.free_surface.saturation", 0.0))
        self.wells = np.zeros_like(self.y)
        for well in case.get("wells", []):
            # A well between two centres takes from both cells, by its distances to them.
            near = np.array([np.interp(well["at_m"][1], self.y, unit) for unit in np.eye(len(self.y))])
            self.wells -= near * well["rate_m3_s"] / case.get("geometry.column.width_m") / self.size

    def cells(self, case, height):
        """Cells no larger than those of the refinement, with faces at the interfaces of layers."""
        size, soils, low = [], [], 0.0
        for layer in case.get("layers", [{"up_to_m": height}]):
            high, own = min(layer["up_to_m"], height), {**case.get("water"), **case.get("soil"), **layer}
            if list(own["law"]) != ["linear_elastic"] or own.get("anisotropy", 1.0) != 1.0:
                unable(case, "only linear elastic, isotropic soil")
            young, nu = (own["law"]["linear_elastic"][key] for key in ("youngs_modulus_pa", "poisson_ratio"))
            soil = (young * (1 - nu) / (1 + nu) / (1 - 2 * nu), own["hydraulic_conductivity_m_s"] / self.unit_weight,
                    own["porosity"], own["grain_density_kg_m3"], bool(own.get("kozeny_carman")))
            n = int(np.ceil((high - low) / case.cell - 1e-6))
            size, soils, low = size + [(high - low) / n] * n, soils + [soil] * n, high
        self.size = np.array(size)
        self.y = np.cumsum(self.size) - self.size / 2
        self.modulus, self.mobility, self.porosity, self.grains, self.narrows = map(np.array, zip(*soils))

    def stress(self, time):
        """Total vertical stress, in compression."""
        return self.weight + sum(load["pressure_pa"] * np.interp(time, *course(load)) for load in self.loads)

    def strain(self, p, stress):
        """Shortening of cells over their first height; at large strain stress is Cauchy's, -M ln J."""
        small = (stress - self.alpha * p) / self.modulus
        return 1 - np.exp(-small) if self.large else small

    def relative(self, p):
        """Relative conductivity, in Gardner's soil the effective saturation, its slope, its integral over p."""
        if not self.unsaturated:
            return np.ones_like(p), np.zeros_like(p), p
        value = np.exp(self.decay * np.minimum(p, 0.0))
        return value, np.where(p < 0, self.decay * value, 0.0), value / self.decay + np.maximum(p, 0.0)

    def water(self, p, stress):
        """Change of water over the first volume of a cell, its slope over p, stretch of cells, mobility."""
        if self.unsaturated:
            value, slope, _ = self.relative(p)
            return self.mobile * value + self.storage * p, self.mobile * slope + self.storage, 1 + 0 * p, self.mobility
        strain = self.strain(p, stress)
        if not self.large:
            change = self.storage * p - self.alpha * strain
            return change, self.storage + self.alpha**2 / self.modulus, 1 + 0 * p, self.mobility
        density, stretch = np.exp(p / self.bulk), 1 - strain  # density over that at no pressure
        water = (self.porosity - strain) * density
        kozeny = lambda n: n**3 / (1 - n)**2
        narrowed = kozeny(1 - (1 - self.porosity) / stretch) / kozeny(self.porosity)
        mobility = self.mobility * density * np.where(self.narrows, narrowed, 1.0)
        return water, stretch * density / self.modulus + water / self.bulk, stretch, mobility

    def ends(self, stage):
        """Pressures at the bottom and the top; None where the end is closed."""
        heights = {"bottom": 0.0, "top": self.case.get("geometry.column.height_m")}
        open_sides = [] if stage.get("drained", "none") == "none" else stage["drained"]
        if set(open_sides) - set(heights):
            unable(self.case, "only the bottom and the top drain")
        fed = {side: table["head_m"] for side, table in self.feed.items() if "head_m" in table}
        pressures = {**dict.fromkeys(open_sides, 0.0), **{s: self.unit_weight * (fed[s] - heights[s]) for s in fed}}
        return [pressures.get(side) for side in heights]

    def sources(self, time):
        """Water that wells and feeds put into cells."""
        source = self.wells.copy()
        for cell, table in ((0, self.feed.get("bottom", {})), (-1, self.feed.get("top", {}))):
            source[cell] += table.get("velocity_m_s", 0.0) * np.interp(time, *course(table)) / self.size[cell]
        return source

    def inflow(self, p, stretch, mobility, ends):
        """Water that two-point fluxes bring into cells, and its derivatives as a band matrix."""
        join = lambda x: np.concatenate((x[:1], x[1:] + x[:-1], x[-1:]))
        half = stretch * self.size / 2
        conduct = 1 / join(half / mobility)  # the harmonic mean of two half cells
        conduct[[0, -1]] *= [end is not None for end in ends]
        around = np.concatenate(([ends[0] or 0.0], p, [ends[1] or 0.0]))
        share, slope, integral = self.relative(around)
        pull = self.pull * join(half) / 2
        flux = -conduct * (np.diff(integral) + pull * (share[1:] + share[:-1]))
        below, above = conduct * (share[:-1] - pull * slope[:-1]), -conduct * (share[1:] + pull * slope[1:])
        band = np.zeros((3, len(p)))
        band[0, 1:] = -above[1:-1] / self.size[:-1]
        band[1] = (above[:-1] - below[1:]) / self.size
        band[2, :-1] = below[1:-1] / self.size[1:]
        return -np.diff(flux) / self.size, band

    def solve(self, held, step, time, p, ends):
        """Pressures at which the cells hold what they held and what comes within the step; the rate of what comes."""
        stress, source = self.stress(time), self.sources(time)
        for _ in range(60):
            water, slope, stretch, mobility = self.water(p, stress)
            rate, band = self.inflow(p, stretch, mobility, ends)  # stretch and mobility are one iteration late
            rate, band = rate + source, -step * band
            band[1] += slope
            change = solve_banded((1, 1), band, held + step * rate - water)
            if self.unsaturated:  # a step of Newton's method for the saturation, in which the equation is linear
                change = np.log1p(np.maximum(self.decay * change, -0.9)) / self.decay
            p = p + change
            if np.abs(change).max() <= 1e-10 * np.abs(p).max():
                return p, rate
        unable(self.case, "Newton's method does not converge")


def start(column):
    """Pressure before the loads, the water in the cells, and the strain from which settlement counts."""
    case, p = column.case, np.zeros_like(column.y)
    if column.unsaturated:
        suction = case.get("water.free_surface.suction_m", column.y - case.get("water.free_surface.level_m", 0.0))
        p = p - column.unit_weight * suction
    stress = p
    if case.get("start") == "given":
        tables = case.get("initial.pressure_pa"), case.get("initial.stress_yy_pa")
        p, tension = (np.interp(column.y, *np.transpose(table)) for table in tables)
        stress = column.alpha * p - tension  # the tension is that of the skeleton
    return p, column.water(p, stress)[0], column.strain(p, stress)


def told(column, p, time, since_stage, first):
    """Rows of what is wanted at a time, which is told from the start of the last stage."""
    for quantity in (name for name, wanted in column.case.wanted.items() if since_stage in wanted["times_s"]):
        if quantity == "settlement":
            strain = column.strain(p, column.stress(time * (1 - 1e-9)))  # a load may jump at that time
            yield quantity, since_stage, None, None, ((strain - first) * column.size).sum()
        else:
            values = p if quantity == "pore_pressure" else column.relative(p)[0]
            yield from ((quantity, since_stage, None, y, value) for y, value in zip(column.y, values))


def run(column):
    """All stages; returns the rows of the answer and the number of steps."""
    case = column.case
    p, water, first = start(column)
    until = np.cumsum([stage["until"]["time_s"] for stage in case.get("stages")])
    before = until[-2] if len(until) > 1 else 0.0
    wanted = {before + t: t for w in case.wanted.values() for t in w["times_s"]}
    sudden = {0.0, *until, *(t for table in [*column.loads, *column.feed.values()] for t in course(table)[0])}
    _, slope, _, mobility = column.water(p, column.stress(0.0))
    least = 0.1 * (column.size**2 * slope / mobility / column.relative(p)[0]).min()
    p, _ = column.solve(water, 0.0, 0.0, p, [None, None])  # sudden loads find the soil undrained
    answer, time, since, steps = list(told(column, p, 0.0, 0.0, first)) if before == 0 else [], 0.0, 0.0, 0
    for mark in sorted(t for t in sudden | set(wanted) if 0 < t <= until[-1] * (1 + 1e-12)):
        ends = column.ends(case.get("stages")[min(np.searchsorted(until, mark), len(until) - 1)])
        while time < mark:
            step = (mark - time) / np.ceil((mark - time) / (least + GROWTH * (time - since)))
            at = lambda share: time + share * step * (1 - 1e-6)  # just before a jump at the end of the step
            p, rate = column.solve(water, GAMMA * step, at(GAMMA), p, ends)
            water = water + (1 - GAMMA) * step * rate
            p, rate = column.solve(water, GAMMA * step, at(1.0), p, ends)
            water = water + GAMMA * step * rate
            time, steps = mark if step == mark - time else time + step, steps + 1
            if column.unsaturated and p.max() > 0:
                unable(case, "soil becomes saturated")
        since = mark if mark in sudden else since
        answer += told(column, p, mark, wanted[mark], first) if mark in wanted else []
    return answer, steps


def main(path, folder, refinement):
    case = Case(path, refinement)
    refuse(case)
    column = Column(case)
    answer, steps = run(column)
    settings = {"cells": len(column.y), "steps": steps, "step_growth": GROWTH, "method": "SDIRK2, two-point fluxes"}
    write(folder, case, answer, "finite-volumes", f"numpy {np.__version__}, scipy {scipy.__version__}", settings)


if __name__ == "__main__":
    main(*sys.argv[1:])

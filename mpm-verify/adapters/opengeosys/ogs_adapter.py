"""Answers a case with OpenGeoSys 6: writes its mesh (VTU) and project file (PRJ), runs `ogs`, reads the results.

    python ogs_adapter.py CASE.json OUT_DIR REFINEMENT

Soil with water is the process HYDRO_MECHANICS (Taylor-Hood: quadratic displacement, linear pressure on eight-node
quadrilaterals, backward Euler), dry soil is SMALL_DEFORMATION. An undrained equilibrium needs no start of its own: a
load that comes at once on unloaded soil brings it within the first, short step.
"""

import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import protocol
from mesh import SIDES, Grid, read
from project import RIGID, all_loads, factor_in_time, project

GROWTH, LARGEST = 0.05, 0.01  # length of a step over the time since a load last began to change, and over all time


def main():
    case = protocol.Case(sys.argv[1], sys.argv[3])
    refuse(case)
    materials, grid = soil_and_mesh(case)
    times = wanted_times(case)
    steps, counts = time_steps(case, times)
    settings = {"process": "SMALL_DEFORMATION", "element": "Quad8", "steps": len(steps)}
    rows = solve(case, materials, grid, times, steps, counts)
    if "water" in case.given:
        # Backward Euler is of first order in time: what steps of half the length change is taken once more.
        halved = solve(case, materials, grid, times, np.repeat(steps, 2) / 2, np.multiply(counts, 2))
        rows = [(*fine[:4], 2 * fine[4] - coarse[4]) for fine, coarse in zip(halved, rows)]
        settings = {"process": "HYDRO_MECHANICS", "element": "Quad8/Quad4", "steps": len(steps),
                    "time": "backward Euler, extrapolated from these steps and their halves"}
    protocol.write(sys.argv[2], case, rows, "OpenGeoSys", version(), settings)


def solve(case, materials, grid, times, steps, counts):
    """Runs the case with these steps and returns the rows of its results."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        grid.write(folder)
        (folder / "case.prj").write_text(project(case, materials, grid, steps, counts))
        run(case, folder)
        outputs = [read(folder / f"out_{step}.vtu") for step in np.cumsum(counts)]
    return [row for time, fields in zip(times, outputs) for row in answers(case, materials, grid, time, fields)]


def refuse(case):
    """Ends with the reason if something is given or wanted that is not modelled here."""
    given, water, wanted = case.given, case.given.get("water", {}), set(case.wanted)
    if "geometry" not in given:
        protocol.unable(case, "it is not a section or column of soil")
    sides, start, reservoirs = given["boundaries"], given["start"], given.get("reservoirs", [])
    soils = [given["soil"], *given.get("layers", []), *given.get("regions", [])]
    loads, height = all_loads(case), case.get("geometry.column.height_m", math.inf)
    reasons = {
        "inertia": case.json["physics"]["inertia"],
        "large strain": case.json["physics"]["strain"] != "small",
        "an outline": "column" not in given["geometry"],
        "partly saturated soil": "free_surface" in water,
        "a law other than linear elasticity": any("linear_elastic" not in soil["law"] for soil in soils),
        "conductivity that depends on porosity or direction": any(
            soil.get("kozeny_carman") or soil.get("anisotropy", 1.0) != 1.0 for soil in [water, *soils]),
        "a side that is not fixed, roller or free": not set(sides.values()) <= {"fixed", "roller", "free"},
        "drainage that changes": len({str(stage.get("drained")) for stage in given["stages"]}) > 1,
        "a load of waves or water": any("wave" in load or load.get("water") for load in loads),
        "a load on something else than a side": not {load["on"] for load in loads} <= set(SIDES),
        "a given start": start not in ("unloaded", "undrained-equilibrium", "geostatic"),
        "weight that settles the soil": "gravity_m_s2" in given and start != "geostatic",
        "more than pore pressure after a geostatic start": start == "geostatic" and wanted != {"pore_pressure"},
        "a reservoir that changes, ends below the top or loads a free side": any(
            len(r["levels"]) > 1 or r["levels"][0][1] < height or sides[r["on"]] == "free" for r in reservoirs),
        "energy about an axis": given["dimension"] == "axisymmetric" and "strain_energy" in wanted,
        "stress or energy of soil with water": bool(water) and wanted & {"mean_stress", "strain_energy"},
        "a result at t = 0": wanted_times(case)[0] + first_stages(case) <= 0.0,
    }
    known = {"boundaries", "dimension", "geometry", "gravity_m_s2", "layers", "loads", "regions", "reservoirs", "soil",
             "stages", "start", "surcharge", "water", "settlement", "pore_pressure", "mean_stress", "strain_energy"}
    reasons |= {what: True for what in sorted((set(given) | wanted) - known)}
    for what, found in reasons.items():
        if found:
            protocol.unable(case, f"{what} is not modelled")


def soil_and_mesh(case):
    """The materials, and the mesh with the number of each cell's material."""
    height, width = case.get("geometry.column.height_m"), case.get("geometry.column.width_m")
    rows, columns = round(height / case.cell), max(1, round(width / case.cell))
    xs = np.linspace(0.0, width, (1 if case.given["dimension"] == "column" else columns) + 1)
    ys = np.linspace(0.0, height, rows + 1)
    plate = case.get("surcharge.on") == "plate"
    if plate:
        ys = np.append(ys, [height + case.cell, height + case.cell + width])
    grid = Grid(xs, ys, rows, case.given["dimension"] == "axisymmetric")
    layers, regions = case.given.get("layers", []), case.given.get("regions", [])
    materials = [material(case, zone) for zone in [case.given["soil"], *layers, *regions]]
    for cell, (x, y) in enumerate(grid.centres):
        for number, layer in reversed(list(enumerate(layers, 1))):
            if y < layer["up_to_m"]:
                grid.material[cell] = number
        for number, region in enumerate(regions, 1 + len(layers)):
            if inside(x, y, region["polygon_m"]):
                grid.material[cell] = number
    if plate:
        # A rigid plate without friction: a thick stiff block on a bed of stiff upright pins that bear no shear.
        stiff = RIGID * max(m["E"] for m in materials)
        block = {"E": stiff, "nu": 0.0, "biot": 0.0, "storage": 0.0,
                 "mobility": min(m["mobility"] for m in materials) / RIGID}
        materials += [block | {"pins": True}, block]
        grid.material[-2 * grid.nx:] = np.repeat([len(materials) - 2, len(materials) - 1], grid.nx)
    return materials, grid


def material(case, zone):
    """Numbers of a soil; its mobility is k/gamma_w."""
    law, porosity, biot = zone["law"]["linear_elastic"], zone["porosity"], zone.get("biot_coefficient", 1.0)
    soil = {"E": law["youngs_modulus_pa"], "nu": law["poisson_ratio"], "biot": biot}
    if "water" in case.given:
        k = zone.get("hydraulic_conductivity_m_s", case.get("water.hydraulic_conductivity_m_s"))
        grains = (biot - porosity) / float(zone.get("grain_bulk_modulus_pa", "inf"))
        soil["mobility"] = k / case.get("water.unit_weight_n_m3")
        soil["storage"] = porosity / case.get("water.bulk_modulus_pa") + grains
    return soil


def inside(x, y, polygon):
    """Whether a place is within a polygon: a ray from it crosses an odd number of sides."""
    odd = False
    for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            odd = not odd
    return odd


def wanted_times(case):
    """All wanted times, counted from the start of the last stage."""
    return sorted({time for wanted in case.wanted.values() for time in wanted["times_s"]})


def first_stages(case):
    """How long all stages but the last take."""
    return sum(stage["until"]["time_s"] for stage in case.given["stages"][:-1])


def time_steps(case, times):
    """Lengths of the steps, and how many of them lead to each wanted time."""
    ends = [time + first_stages(case) for time in times]
    if "water" not in case.given:
        return np.diff([0.0, *ends]), [1] * len(ends)
    changes = [time for load in all_loads(case) for time, _ in factor_in_time(load)]
    near = 1e-9 * ends[-1]
    kinks = {time for time in changes if near < time < ends[-1] and all(abs(time - end) > near for end in ends)}
    shortest, change, now, steps, counts = GROWTH * min([*ends, *kinks]), 0.0, 0.0, [], []
    for stop in sorted([*ends, *kinks]):
        part, at = [], now
        while at < stop:
            part.append(max(shortest, min(GROWTH * (at - change), LARGEST * ends[-1])))
            at += part[-1]
        steps += [step * (stop - now) / sum(part) for step in part]
        now = stop
        if any(abs(stop - time) <= near for time in changes):
            change = stop
        if stop in ends:
            counts.append(len(steps) - sum(counts))
    return steps, counts


def program():
    """The program: in the path, or beside this Python."""
    return shutil.which("ogs") or str(pathlib.Path(sys.executable).parent / "ogs")


def version():
    said = subprocess.run([program(), "--version"], capture_output=True, text=True).stdout
    return said.split("version:")[1].split()[0]


def run(case, folder):
    done = subprocess.run([program(), "case.prj", "-l", "warn"], cwd=folder, capture_output=True, text=True,
                          env=os.environ | {"OMP_NUM_THREADS": "1"})
    if done.returncode:
        protocol.unable(case, "ogs: " + " ".join((done.stdout + done.stderr).split())[-400:])


def answers(case, materials, grid, time, fields):
    """Rows of all that is wanted at a time."""
    rows, centres = [], grid.centres[:grid.nx * grid.soil_rows]
    for quantity in [quantity for quantity, wanted in case.wanted.items() if time in wanted["times_s"]]:
        if quantity == "settlement":
            rows.append((quantity, time, None, None, -grid.surface_mean(fields["displacement"][:, 1])))
        elif quantity == "strain_energy":
            rows.append((quantity, time, None, None, strain_energy(materials, grid, gauss_stress(fields))))
        else:
            # At the centre of a cell, the mean of the corners of a bilinear field, or of the Gauss points.
            values = (fields["pressure"][grid.cells[:, :4]] if quantity == "pore_pressure"
                      else gauss_stress(fields)[..., :3].mean(axis=2)).mean(axis=1)
            rows += [(quantity, time, x, y, value) for (x, y), value in zip(centres, values)]
    return rows


def gauss_stress(fields):
    """Stress of each cell at four Gauss points: xx, yy, zz, xy."""
    return fields["sigma_ip"].reshape(-1, 4, 4)


def strain_energy(materials, grid, stress):
    """Elastic energy of dry soil."""
    e, nu = (np.array([m[key] for m in materials])[grid.material, None] for key in ("E", "nu"))
    density = ((1 + nu) * (stress**2 @ [1, 1, 1, 2]) - nu * stress[..., :3].sum(axis=2) ** 2) / (2 * e)
    return (density.mean(axis=1) * np.outer(np.diff(grid.ys), np.diff(grid.xs)).ravel()).sum()


if __name__ == "__main__":
    main()

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

GROWTH, LARGEST = 0.05, 0.01  # length of a step over the time since a load last began to change, and over all time
RIGID = 1e5  # stiffness of a plate over that of the stiffest soil


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


# Soil and its mesh


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


# Time


def wanted_times(case):
    """All wanted times, counted from the start of the last stage."""
    return sorted({time for wanted in case.wanted.values() for time in wanted["times_s"]})


def first_stages(case):
    """How long all stages but the last take."""
    return sum(stage["until"]["time_s"] for stage in case.given["stages"][:-1])


def factor_in_time(load):
    """Times and factors of a load."""
    ramp = load.get("ramp_time_s", 0.0)
    return load.get("times") or ([[0.0, 0.0], [ramp, 1.0]] if ramp > 0.0 else [[0.0, 1.0]])


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


# Project file


def all_loads(case):
    """Loads on sides; a surcharge is one on the top."""
    surcharge = case.given.get("surcharge")
    return ([surcharge | {"on": "top"}] if surcharge else []) + case.given.get("loads", [])


def tag(name, *content):
    return f"<{name}>{''.join(map(str, content))}</{name}>"


def constant(name, value):
    return tag("property", tag("name", name), tag("type", "Constant"), tag("value", value))


def parameter(name, *values):
    return tag("parameter", tag("name", name), tag("type", "Constant"), tag("values", " ".join(map(repr, values))))


def function(name, expression):
    return tag("parameter", tag("name", name), tag("type", "Function"), tag("expression", expression))


def condition(side, kind, component, value):
    return tag("boundary_condition", tag("mesh", side), tag("type", kind), tag("component", component),
               tag("parameter", value))


def medium(number, m, case):
    """Water and grains. The density of water changes linearly with pressure, which gives the storage."""
    if "water" not in case.given:
        solid = tag("phase", tag("type", "Solid"), tag("properties", constant("density", 0.0)))
        return f'<medium id="{number}">{tag("phases", solid)}</medium>'
    # OpenGeoSys derives the grains' stiffness from Biot's coefficient and adds their storage by itself, unless the
    # porosity equals that coefficient; porosity acts on nothing else here, so the whole storage goes to the water.
    porosity = m["biot"]
    law = tag("independent_variable", tag("variable_name", "liquid_phase_pressure"), tag("reference_condition", 0.0),
              tag("slope", m["storage"] / porosity if porosity else 0.0))
    water = tag("property", tag("name", "density"), tag("type", "Linear"),
                tag("reference_value", case.get("water.density_kg_m3")), law)
    # Weight under water is in balance with the stress of a geostatic start: only buoyancy is left, grains have none.
    phases = [tag("phase", tag("type", kind), tag("properties", *properties)) for kind, properties in
              (("AqueousLiquid", (water, constant("viscosity", 1.0))), ("Solid", (constant("density", 0.0),)))]
    properties = [constant("permeability", m["mobility"]), constant("porosity", porosity),
                  constant("biot_coefficient", m["biot"]), constant("reference_temperature", 293.15)]
    return f'<medium id="{number}">{tag("phases", *phases)}{tag("properties", *properties)}</medium>'


def solid(number, m):
    """The constitutive relation of a material and its parameters."""
    stiff, soft = m["E"], m["E"] / RIGID**2
    names = [f"{name}{number}" for name in ("E", "nu", "G")]
    if m.get("pins"):
        kinds, values = ("Orthotropic", "youngs_moduli", "poissons_ratios", "shear_moduli"), (
            (soft, stiff, soft), (0.0,) * 3, (soft,) * 3)
    else:
        kinds, values = ("Isotropic", "youngs_modulus", "poissons_ratio"), ((stiff,), (m["nu"],))
    law = tag("type", "LinearElastic" + kinds[0]) + "".join(map(tag, kinds[1:], names))
    return (f'<constitutive_relation id="{number}">{law}</constitutive_relation>',
            "".join(parameter(name, *value) for name, value in zip(names, values)))


def load_conditions(case):
    """Boundary conditions, parameters and curves of the loads: share along x times factor in time."""
    conditions, parameters, curves = [], [], []
    for number, load in enumerate(all_loads(case)):
        pressure, strip = load["pressure_pa"], load.get("strip")
        sign, component = {"bottom": (1, 1), "right": (-1, 0), "top": (-1, 1), "left": (1, 0)}[load["on"]]
        share = "1"
        if strip:
            out = f"max({strip['from_m']!r} - x, x - {strip['to_m']!r}, 0)"
            taper = strip.get("taper_m", 0.0)
            fall = f"if({out} &lt; {taper!r}, cos({math.pi / 2!r} * {out} / {taper!r})^2, 0)" if taper else "0"
            share = f"if({out} &lt;= 0, 1, {fall})"
        history = factor_in_time(load)
        history = [*history, [history[-1][0] + 1e30, history[-1][1]]]
        coords, values = (" ".join(repr(float(row[k])) for row in history) for k in (0, 1))
        parameters += [function(f"share{number}", f"{sign * pressure!r} * {share}"),
                       tag("parameter", tag("name", f"load{number}"), tag("type", "CurveScaled"),
                           tag("curve", f"curve{number}"), tag("parameter", f"share{number}"))]
        curves.append(tag("curve", tag("name", f"curve{number}"), tag("coords", coords), tag("values", values)))
        conditions.append(condition(load["on"], "Neumann", component, f"load{number}"))
    return conditions, parameters, curves


def held_sides(case):
    """Conditions of displacement, those of pressure, and the parameters of the latter."""
    given, moves, pressures, parameters = case.given, [], [], []
    gamma = case.get("gravity_m_s2", 0.0) * case.get("water.density_kg_m3", 0.0)
    for side, kind in given["boundaries"].items():
        held = {"fixed": (0, 1), "roller": (0 if side in ("left", "right") else 1,), "free": ()}[kind]
        moves += [condition(side, "Dirichlet", component, "zero") for component in held]
    drained = given["stages"][-1].get("drained", "none")
    pressures += [condition(side, "Dirichlet", 0, "zero") for side in SIDES if drained != "none" and side in drained]
    for number, reservoir in enumerate(given.get("reservoirs", [])):
        parameters.append(function(f"level{number}", f"{gamma!r} * ({reservoir['levels'][0][1]!r} - y)"))
        pressures.append(condition(reservoir["on"], "Dirichlet", 0, f"level{number}"))
    start = function("p_0", f"{gamma!r} * ({case.get('geometry.column.height_m')!r} - y)")
    return moves, pressures, [*parameters, start]


def project(case, materials, grid, steps, counts):
    """The text of the project file."""
    laws, numbers = zip(*(solid(*item) for item in enumerate(materials)))
    loads, load_parameters, curves = load_conditions(case)
    moves, pressures, pressure_parameters = held_sides(case)
    parameters = [*numbers, *load_parameters, *pressure_parameters, parameter("zero", 0.0), parameter("rest", 0.0, 0.0)]
    if "water" in case.given:
        process, order, output = "HYDRO_MECHANICS", 3, "pressure"
        variables = [("pressure", "pressure", 1, 1, "p_0", pressures)]
    else:
        process, order, output, variables = "SMALL_DEFORMATION", 2, "sigma_ip", []
    name = "displacement" if variables else "process_variable"
    variables.append((name, "displacement", 2, 2, "rest", moves + loads))
    unknowns = [tag("process_variable", tag("name", name), tag("components", size), tag("order", degree),
                    tag("initial_condition", start), tag("boundary_conditions", *conditions))
                for _, name, size, degree, start, conditions in variables]
    mesh = f'<mesh axially_symmetric="{"true" if grid.axis else "false"}">'
    # All is linear but for a density that hardly changes: one iteration of Newton's is enough, whatever it changes.
    return f"""<OpenGeoSysProject>
<meshes>{"".join(f"{mesh}{name}.vtu</mesh>" for name in ("soil", *SIDES))}</meshes>
<processes><process><name>soil</name><type>{process}</type><integration_order>{order}</integration_order>
{"".join(laws)}{tag("process_variables", *(tag(kind, name) for kind, name, *_ in variables))}
<secondary_variables/><specific_body_force>0 {-case.get("gravity_m_s2", 0.0)!r}</specific_body_force></process></processes>
<media>{"".join(medium(number, m, case) for number, m in enumerate(materials))}</media>
<time_loop><processes><process ref="soil"><nonlinear_solver>newton</nonlinear_solver>
<convergence_criterion><type>PerComponentDeltaX</type><norm_type>INFINITY_N</norm_type>
<abstols>{"1e30 " * sum(size for _, _, size, *_ in variables)}</abstols></convergence_criterion>
<time_discretization><type>BackwardEuler</type></time_discretization>
<time_stepping><type>FixedTimeStepping</type><t_initial>0</t_initial><t_end>{float(sum(steps))!r}</t_end>
<timesteps>{"".join(f"<pair><repeat>1</repeat><delta_t>{float(step)!r}</delta_t></pair>" for step in steps)}</timesteps>
</time_stepping></process></processes>
<output><type>VTK</type><prefix>out</prefix><suffix>_{{:timestep}}</suffix><data_mode>Binary</data_mode>
<compress_output>false</compress_output>
<timesteps>{"".join(f"<pair><repeat>1</repeat><each_steps>{count}</each_steps></pair>" for count in counts)}</timesteps>
<variables><variable>displacement</variable><variable>{output}</variable></variables></output></time_loop>
<parameters>{"".join(parameters)}</parameters>{tag("curves", *curves) if curves else ""}
<process_variables>{"".join(unknowns)}</process_variables>
<nonlinear_solvers><nonlinear_solver><name>newton</name><type>Newton</type><max_iter>20</max_iter>
<linear_solver>direct</linear_solver></nonlinear_solver></nonlinear_solvers>
<linear_solvers><linear_solver><name>direct</name><eigen><solver_type>SparseLU</solver_type><scaling>true</scaling></eigen>
</linear_solver></linear_solvers></OpenGeoSysProject>"""


# Run and results


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

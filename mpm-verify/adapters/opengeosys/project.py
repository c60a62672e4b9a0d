"""Project files of OpenGeoSys: materials, loads, held sides and steps of a case as PRJ text."""

import math

from mesh import SIDES

RIGID = 1e5  # stiffness of a plate over that of the stiffest soil


def all_loads(case):
    """Loads on sides; a surcharge is one on the top."""
    surcharge = case.given.get("surcharge")
    return ([surcharge | {"on": "top"}] if surcharge else []) + case.given.get("loads", [])


def factor_in_time(load):
    """Times and factors of a load."""
    ramp = load.get("ramp_time_s", 0.0)
    return load.get("times") or ([[0.0, 0.0], [ramp, 1.0]] if ramp > 0.0 else [[0.0, 1.0]])


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
<secondary_variables/><specific_body_force>0 {-case.get("gravity_m_s2", 0.0)!r}</specific_body_force>
</process></processes>
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
<linear_solvers><linear_solver><name>direct</name>
<eigen><solver_type>SparseLU</solver_type><scaling>true</scaling></eigen></linear_solver></linear_solvers>
</OpenGeoSysProject>"""

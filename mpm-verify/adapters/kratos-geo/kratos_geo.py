"""Answers cases of elastic soil and its water at small strain with Kratos GeoMechanics.

    python kratos_geo.py CASE.json OUT_DIR REFINEMENT

A mesh of rectangles with quadratic displacement and linear pressure, materials and project parameters are written to a
temporary folder, and GeoMechanicsAnalysis runs them with the U-Pw solver. Three things of that analysis are our own:
the length of each step, the values on the sides in time, and which results are kept. Kratos counts water pressure
negative in compression.
"""

import importlib.metadata
import json
import math
import os
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from protocol import Case, unable, write

import KratosMultiphysics as Kratos
import KratosMultiphysics.LinearSolversApplication
import KratosMultiphysics.GeoMechanicsApplication as Geo
from KratosMultiphysics.GeoMechanicsApplication.geomechanics_analysis import GeoMechanicsAnalysis

VISCOSITY = 1e-3  # Pa s; only its ratio to the intrinsic permeability counts
RIGID = 1e30  # Pa, for water or grains that do not compress
GROWTH = 0.04  # a step as a share of the time since the last kink of the loads or start of a stage
FIRST_STEP = 0.02  # the shortest step as a share of the time in which pressure passes one cell
STRAIN = Kratos.KratosGlobals.GetVariable("ENGINEERING_STRAIN_VECTOR")
DISPLACEMENT = {"x": Kratos.DISPLACEMENT_X, "y": Kratos.DISPLACEMENT_Y}
ACROSS = {"left": "x", "right": "x", "bottom": "y", "top": "y"}
SOIL = "grain_density_kg_m3 law porosity biot_coefficient grain_bulk_modulus_pa"
KNOWN = {
    "": "boundaries dimension geometry soil layers water stages start surcharge loads plates initial",
    "geometry": "column",
    "soil": SOIL,
    "layers": SOIL + " up_to_m anisotropy bedding_angle_deg hydraulic_conductivity_m_s kozeny_carman",
    "water": "bulk_modulus_pa density_kg_m3 hydraulic_conductivity_m_s unit_weight_n_m3",
    "stages": "drained until damping_per_s",  # damping: there are no velocities that it could act on
    "surcharge": "on pressure_pa ramp_time_s strip",
    "loads": "on pressure_pa ramp_time_s times",
    "plates": "on displacement_m ramp_time times rough velocity_m_s",
    "initial": "pressure_pa stress_yy_pa",
}


def refuse_unknown(case):
    """Ends where the case has anything that this adapter would otherwise pass over in silence."""
    given, start, physics = case.given, case.get("start"), case.json["physics"]
    if not {"dimension", "soil", "boundaries", "stages"} <= set(given):
        unable(case, "no column or section of soil")
    for part, known in KNOWN.items():
        items = given.get(part, {}) if part else given
        for item in items if isinstance(items, list) else [items]:
            if strange := sorted(set(item) - set(known.split())):
                unable(case, f"no support for {part + '.' if part else ''}{strange[0]}")
    layers = [given["soil"], *given.get("layers", [])]
    biot = case.get("soil.biot_coefficient", 1.0)
    balanced = case.get("initial.stress_yy_pa") == [[y, biot * p] for y, p in case.get("initial.pressure_pa", [])]
    checks = {
        "quasi-static small strain only": physics["inertia"] or physics["strain"] != "small",
        "unknown dimension": given["dimension"] not in ("column", "plane-strain", "axisymmetric"),
        "linear elastic soil only": any(set(soil["law"]) != {"linear_elastic"} for soil in layers),
        "no support for conductivity that varies with direction or porosity": any(
            soil.get("kozeny_carman", False) or soil.get("anisotropy", 1.0) != 1.0 for soil in layers),
        "no support for periodic sides": not set(given["boundaries"].values()) <= {"free", "roller", "fixed"},
        "stages of a given time only": any(set(stage["until"]) != {"time_s"} for stage in given["stages"]),
        f"no support for start = {start}": start not in ("unloaded", "undrained-equilibrium", "given"),
        "no support for undrained equilibrium under a ramp":
            start == "undrained-equilibrium" and case.get("surcharge.ramp_time_s", 0.0) > 0.0,
        "of given starts only columns without total stress":
            start == "given" and not (given["dimension"] == "column" and balanced),
        "plates on the top only": any(plate["on"] != "top" for plate in given.get("plates", [])),
        "no energy about an axis": given["dimension"] == "axisymmetric" and "strain_energy" in case.wanted,
        "unknown quantities": any(not hasattr(Analysis, "find_" + quantity) for quantity in case.wanted),
    }
    for why, failed in checks.items():
        if failed:
            unable(case, why)


def soils(case):
    """From the base up: the height of each layer, its diffusivity, and its constants as Kratos names them."""
    found, base = [], 0.0
    whole = case.given["soil"] | {"up_to_m": case.get("geometry.column.height_m")}
    for layer in case.given.get("layers") or [whole]:
        young, nu = (layer["law"]["linear_elastic"][key] for key in ("youngs_modulus_pa", "poisson_ratio"))
        bulk = young / (3.0 * (1.0 - 2.0 * nu))
        grains = layer.get("grain_bulk_modulus_pa", math.inf)
        biot = layer.get("biot_coefficient", 1.0 - bulk / grains)
        if biot < 1.0 and grains == math.inf:
            grains = bulk / (1.0 - biot)
        water, porosity = case.get("water.bulk_modulus_pa", math.inf), layer["porosity"]
        conductivity = layer.get("hydraulic_conductivity_m_s", case.get("water.hydraulic_conductivity_m_s", 0.0))
        mobility = conductivity / case.get("water.unit_weight_n_m3", 1.0)
        oedometer = 3.0 * bulk * (1.0 - nu) / (1.0 + nu)
        storage = porosity / water + (biot - porosity) / grains
        variables = {
            "YOUNG_MODULUS": young, "POISSON_RATIO": nu, "POROSITY": porosity, "BIOT_COEFFICIENT": biot,
            "DENSITY_SOLID": layer["grain_density_kg_m3"], "DENSITY_WATER": case.get("water.density_kg_m3", 1000.0),
            "BULK_MODULUS_SOLID": min(grains, RIGID), "BULK_MODULUS_FLUID": min(water, RIGID),
            "PERMEABILITY_XX": mobility * VISCOSITY, "PERMEABILITY_YY": mobility * VISCOSITY, "PERMEABILITY_XY": 0.0,
            "DYNAMIC_VISCOSITY": VISCOSITY,
            "RETENTION_LAW": "SaturatedLaw", "SATURATED_SATURATION": 1.0, "RESIDUAL_SATURATION": 0.0,
        }
        found.append((layer["up_to_m"] - base, mobility / (biot**2 / oedometer + storage), variables))
        base = layer["up_to_m"]
    return found


class Mesh:
    """Rectangles of eight nodes: counterclockwise their corners, then the middles of their edges."""

    def __init__(self, case, layers):
        columns = 1 if case.given["dimension"] == "column" else round(case.get("geometry.column.width_m") / case.cell)
        y, owner = [0.0], []
        for number, (height, _, _) in enumerate(layers, 1):  # every interface is a line of the mesh
            rows = max(1, round(height / case.cell))
            y += [y[-1] + height * 0.5 * (row + 1) / rows for row in range(2 * rows)]
            owner += [number] * rows
        x = np.linspace(0.0, case.get("geometry.column.width_m"), 2 * columns + 1).tolist()
        places = [(i, j) for j in range(len(y)) for i in range(len(x)) if i % 2 == 0 or j % 2 == 0]
        ids = {place: number for number, place in enumerate(places, 1)}
        self.nodes = {ids[i, j]: (x[i], y[j]) for i, j in places}
        around = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
        self.cells = [(owner[row], [ids[2 * column + i, 2 * row + j] for i, j in around])
                      for row in range(len(owner)) for column in range(columns)]
        right, top = len(x) - 1, len(y) - 1
        self.sides = {  # with the soil on their left: then a normal stress above zero presses on it
            "bottom": [ids[i, 0] for i in range(right + 1)],
            "right": [ids[right, j] for j in range(top + 1)],
            "top": [ids[i, top] for i in range(right, -1, -1)],
            "left": [ids[0, j] for j in range(top, -1, -1)],
        }

    def edges(self, side):
        nodes = self.sides[side]
        return [(nodes[i], nodes[i + 2], nodes[i + 1]) for i in range(0, len(nodes) - 2, 2)]

    def write(self, path, element, condition, loaded):
        """Writes the mesh in Kratos' format, with a part for each soil and one for the loaded sides."""
        cells = list(enumerate(self.cells, 1))
        edges = list(enumerate((edge for side in loaded for edge in self.edges(side)), 1))
        owners = sorted({owner for owner, _ in self.cells})
        out = [line for owner in owners for line in block(f"Properties {owner}", [])]
        out += block("Nodes", [(node, *place, 0.0) for node, place in self.nodes.items()])
        out += block(f"Elements {element}", [(n, owner, *nodes) for n, (owner, nodes) in cells])
        out += block(f"Conditions {condition}", [(n, 1, *nodes) for n, nodes in edges])
        for owner in owners:
            out += part(f"soil_{owner}", "Elements", [(n, nodes) for n, (own, nodes) in cells if own == owner])
        out += part("loaded", "Conditions", edges)
        path.write_text("\n".join(out) + "\n")


def block(head, rows):
    return [f"Begin {head}", *(" ".join(map(str, row)) for row in rows), f"End {head.split()[0]}"]


def part(name, kind, members):
    nodes = sorted({node for _, nodes in members for node in nodes})
    inside = block("SubModelPartNodes", zip(nodes)) + block(f"SubModelPart{kind}", [[n] for n, _ in members])
    return [f"Begin SubModelPart {name}", *inside, "End SubModelPart"]


def polyline(item):
    return item.get("times") or [[0.0, 0.0], [item.get("ramp_time_s", item.get("ramp_time", 0.0)), 1.0]]


def course(item, time):
    """The factor on a load or plate; at a jump that before it, so that a step which ends there does not see it."""
    return float(np.interp(np.nextafter(time, -1.0), *zip(*polyline(item))))


def pressure(load, x, time):
    """The pressure of a surcharge or load at a place of its side."""
    shape = 1.0
    if strip := load.get("strip"):
        outside, taper = max(strip["from_m"] - x, x - strip["to_m"], 0.0), strip.get("taper_m", 0.0)
        shape = math.cos(0.5 * math.pi * outside / taper) ** 2 if outside < taper else float(outside == 0.0)
    return load["pressure_pa"] * shape * course(load, time)


def plan(case, layers, moved):
    """The steps, (stage, time since the start of the run, length, wanted time or None): short after each kink, then
    longer, so that what they do not resolve has died away."""
    ends = np.cumsum([stage["until"]["time_s"] for stage in case.given["stages"]]).tolist()
    kinks = sorted({0.0, *ends, *(time for item in moved for time, _ in polyline(item))})
    kinks = {time for before, time in zip([-1.0, *kinks], kinks) if time - before > 1e-9 * ends[-1]}
    asked = {}
    for wanted in {time for wanted in case.wanted.values() for time in wanted["times_s"]}:
        time = wanted + (ends[-2] if len(ends) > 1 else 0.0)
        nearest = min(kinks, key=lambda kink: abs(kink - time))
        asked[nearest if abs(nearest - time) < 1e-9 * ends[-1] else time] = wanted
    stops = sorted(time for time in kinks | set(asked) if 0.0 < time <= ends[-1])
    shortest = stops[0] / 10.0
    if fastest := max(diffusivity for _, diffusivity, _ in layers):
        shortest = min(shortest, FIRST_STEP * case.cell**2 / fastest)
    steps, now, kink = [], 0.0, 0.0
    if case.given["start"] == "given":
        steps.append(("start", 0.0, shortest, None))
    for stop in stops:
        stage = int(np.searchsorted(ends, stop))
        while now < stop:
            parts = math.ceil((stop - now) / max(shortest, GROWTH * (now - kink)) * (1.0 - 1e-9))
            length = (stop - now) / parts
            now = stop if parts == 1 else now + length
            steps.append((stage, now, length, asked.get(now)))
        kink = stop if stop in kinks else kink
    return steps


class Analysis(GeoMechanicsAnalysis):
    """Kratos' analysis with the planned steps, the values on the sides in time, and the wanted results kept."""

    def __init__(self, parameters, case, mesh, layers, loads):
        super().__init__(Kratos.Model(), parameters)
        self.case, self.mesh, self.loads, self.plates = case, mesh, loads, case.given.get("plates", [])
        self.steps = plan(case, layers, self.loads + self.plates)
        self.rows, self.done, self.stage, self.datum = [], 0, None, 0.0

    def ModifyInitialGeometry(self):
        self.part = self._GetSolver().GetComputingModelPart()
        self.part.AddConditions([condition.Id for condition in self.model["PorousDomain.loaded"].Conditions])
        for side, support in self.case.given["boundaries"].items():
            self.fix(side, {"free": "", "roller": ACROSS[side], "fixed": "xy"}[support])
        for plate in self.plates:
            self.fix("top", "xy" if plate.get("rough") else "y")
        if self.case.get("surcharge.on") == "plate":  # rigid, without friction: the top settles alike
            first, *others = (self.part.Nodes[number] for number in self.mesh.sides["top"])
            for number, other in enumerate(others, 1):
                self.part.CreateNewMasterSlaveConstraint("LinearMasterSlaveConstraint", number, first,
                                                         DISPLACEMENT["y"], other, DISPLACEMENT["y"], 1.0, 0.0)

    def fix(self, side, directions):
        for number in self.mesh.sides[side]:
            for direction in directions:
                self.part.Nodes[number].Fix(DISPLACEMENT[direction])

    def KeepAdvancingSolutionLoop(self):
        if self.done == len(self.steps):
            return False
        stage, self.now, self.delta_time, self.wanted_time = self.steps[self.done]
        self.done += 1
        if stage != self.stage:
            self.enter(stage)
        return True

    def enter(self, stage):
        """Drainage of a stage. Rates of the one before belong to other conditions and are dropped."""
        for node in self.part.Nodes:
            node.Free(Kratos.WATER_PRESSURE)
            node.SetSolutionStepValue(Kratos.VELOCITY, Kratos.Array3([0.0, 0.0, 0.0]))
            node.SetSolutionStepValue(Geo.DT_WATER_PRESSURE, 0.0)
        held, nodes = [[0.0, 0.0]], self.mesh.nodes  # dry soil
        if stage == "start":
            held = self.case.get("initial.pressure_pa")
        elif "water" in self.case.given:
            drained = self.case.given["stages"][stage].get("drained", "none")
            nodes = [node for side in self.mesh.sides if side in drained for node in self.mesh.sides[side]]
        for number in nodes:
            value = -np.interp(self.mesh.nodes[number][1], *zip(*held))
            self.part.Nodes[number].Fix(Kratos.WATER_PRESSURE)
            self.part.Nodes[number].SetSolutionStepValue(Kratos.WATER_PRESSURE, value)
        self.stage = stage

    def ApplyBoundaryConditions(self):
        super().ApplyBoundaryConditions()
        for side in {load["on"] for load in self.loads}:
            for number in self.mesh.sides[side]:
                x = self.mesh.nodes[number][0]
                value = sum(pressure(load, x, self.now) for load in self.loads if load["on"] == side)
                self.part.Nodes[number].SetSolutionStepValue(Kratos.NORMAL_CONTACT_STRESS, value)
        for plate in self.plates:
            way = plate.get("displacement_m", 0.0) * course(plate, self.now) + plate.get("velocity_m_s", 0.0) * self.now
            for number in self.mesh.sides["top"]:
                self.part.Nodes[number].SetSolutionStepValue(DISPLACEMENT["y"], -way)

    def OutputSolutionStep(self):
        if self.stage == "start":  # settlement counts from a given start
            self.datum = next(self.find_settlement())[2]
        for quantity, wanted in self.case.wanted.items():
            if self.wanted_time in wanted["times_s"]:
                self.rows += [(quantity, self.wanted_time, *row) for row in getattr(self, "find_" + quantity)()]

    def nodal(self, number, variable):
        return self.part.Nodes[number].GetSolutionStepValue(variable)

    def inner(self, number, variable):
        """Vectors at the 2 x 2 points of integration of an element, which weigh the same in a rectangle."""
        return np.array(self.part.Elements[number].CalculateOnIntegrationPoints(variable, self.part.ProcessInfo))

    def centre(self, nodes):
        x, y = np.mean([self.mesh.nodes[node] for node in nodes[:4]], axis=0)
        return (None if self.case.given["dimension"] == "column" else x), y

    def find_settlement(self):
        way = whole = 0.0
        for edge in self.mesh.edges("top"):
            for node, weight in zip(edge, (1.0, 1.0, 4.0)):  # Simpson's rule
                weight *= self.mesh.nodes[node][0] if self.case.given["dimension"] == "axisymmetric" else 1.0
                way, whole = way - weight * self.nodal(node, DISPLACEMENT["y"]), whole + weight
        yield None, None, way / whole - self.datum

    def find_pore_pressure(self):
        for _, nodes in self.mesh.cells:
            yield *self.centre(nodes), -np.mean([self.nodal(node, Kratos.WATER_PRESSURE) for node in nodes[:4]])

    def find_plate_force(self):
        yield None, None, sum(self.nodal(node, Kratos.REACTION_Y) for node in self.mesh.sides["top"])

    def find_mean_stress(self):
        for number, (_, nodes) in enumerate(self.mesh.cells, 1):
            yield *self.centre(nodes), self.inner(number, Kratos.CAUCHY_STRESS_VECTOR)[:, :3].mean()

    def find_strain_energy(self):
        energy = 0.0
        for element in self.part.Elements:
            products = self.inner(element.Id, Kratos.CAUCHY_STRESS_VECTOR) * self.inner(element.Id, STRAIN)
            energy += 0.5 * products.sum(axis=1).mean() * element.GetGeometry().Area()
        yield None, None, energy


def parameters(folder, layers):
    """Writes project and material parameters. The trapezoidal rule in time: theta = 1/2 for the water, and for the soil
    beta = gamma/2 with gamma = 1, whose velocities are the same but do not pass through accelerations."""
    parts = [f"soil_{number}" for number in range(1, len(layers) + 1)]
    law = {"name": "GeoLinearElasticPlaneStrain2DLaw"}
    material = {"properties": [{
        "model_part_name": f"PorousDomain.{name}",
        "properties_id": number,
        "Material": {"constitutive_law": law, "Variables": variables, "Tables": {}},
    } for number, (name, (_, _, variables)) in enumerate(zip(parts, layers), 1)]}
    (folder / "MaterialParameters.json").write_text(json.dumps(material, indent=2))
    project = {
        "problem_data": {"problem_name": "case", "start_time": 0.0, "end_time": 1e30, "echo_level": 0,
                         "parallel_type": "OpenMP", "number_of_threads": 1},
        "solver_settings": {
            "solver_type": "U_Pw", "model_part_name": "PorousDomain", "domain_size": 2, "echo_level": 0,
            "model_import_settings": {"input_type": "mdpa", "input_filename": str(folder / "mesh")},
            "material_import_settings": {"materials_filename": str(folder / "MaterialParameters.json")},
            "time_stepping": {"time_step": 1.0, "minimum_allowable_value": 1e-30, "max_delta_time_factor": 1e30},
            "solution_type": "quasi_static", "strategy_type": "linear", "min_iterations": 0,
            "scheme_type": "newmark", "newmark_beta": 0.5, "newmark_gamma": 1.0, "newmark_theta": 0.5,
            "compute_reactions": True,  # without it the linear strategy leaves the stresses as they were
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
            "problem_domain_sub_model_part_list": parts, "body_domain_sub_model_part_list": parts,
        },
    }
    (folder / "ProjectParameters.json").write_text(json.dumps(project, indent=2))
    return Kratos.Parameters((folder / "ProjectParameters.json").read_text())


def main():
    case_path, out, refinement = sys.argv[1:]
    case = Case(case_path, refinement)
    refuse_unknown(case)
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    layers = soils(case)
    mesh = Mesh(case, layers)
    loads = [*case.given.get("loads", []), *(s | {"on": "top"} for s in [case.given.get("surcharge")] if s)]
    axis = "Axisymmetric" if case.given["dimension"] == "axisymmetric" else ""
    element, condition = f"SmallStrainUPwDiffOrder{axis}Element2D8N", f"{axis}LineNormalLoadDiffOrderCondition2D3N"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        mesh.write(folder / "mesh.mdpa", element, condition, sorted({load["on"] for load in loads}))
        analysis = Analysis(parameters(folder, layers), case, mesh, layers, loads)
        analysis.Run()
    settings = f"{element}, trapezoidal rule, {len(analysis.steps)} steps of {GROWTH:g} of the time since the last kink"
    version = importlib.metadata.version("KratosGeoMechanicsApplication")
    write(out, case, analysis.rows, "Kratos GeoMechanics", version, settings)


if __name__ == "__main__":
    main()

"""A finite-difference column of consolidation: implicit steps in time, nothing but Python's standard library."""
import csv, json, pathlib, sys


def problem(case):  # the numbers of a column from what is given: soils from the base up, load, drainage
    given, water = case["given"], case["given"]["water"]
    beyond = set(given) & {"loads", "wells", "gravity_m_s2", "initial"} or "biot_coefficient" in given["soil"]
    if given["dimension"] != "column" or beyond or case["physics"] != {"inertia": False, "strain": "small"}:
        sys.exit("not answered: expected a column under one load, without weight, inertia or large strain")
    soils, load = [dict(given["soil"], **layer) for layer in given.get("layers", [{}])], given.get("surcharge", {})
    return {"H": given["geometry"]["column"]["height_m"], "tops": [soil.get("up_to_m", float("inf")) for soil in soils],
        "E": [soil["law"]["linear_elastic"]["youngs_modulus_pa"] for soil in soils],
        "nu": [soil["law"]["linear_elastic"]["poisson_ratio"] for soil in soils],
        "k": [soil.get("hydraulic_conductivity_m_s", water["hydraulic_conductivity_m_s"]) for soil in soils],
        "n": [soil["porosity"] for soil in soils], "Kw": float(str(water["bulk_modulus_pa"]).replace("infinite", "inf")),
        "gamma_w": water["unit_weight_n_m3"], "drained": given["stages"][0]["drained"],
        "q": load.get("pressure_pa", 0.0), "ramp": load.get("ramp_time_s", 0.0)}


def solve(p, cells, times):  # settlement and the pore pressures at the nodes, from the base up, at each time
    h = p["H"] / cells
    soil = [next(s for s, top in enumerate(p["tops"]) if (e + 0.5) * h < top) for e in range(cells)]
    modulus = [p["E"][s] * (1 - p["nu"][s]) / ((1 + p["nu"][s]) * (1 - 2 * p["nu"][s])) for s in soil]
    at_nodes = lambda of: [0.5 * h * (a + b) for a, b in zip([0.0, *of], [*of, 0.0])]
    flow, squeeze = [p["k"][s] / p["gamma_w"] / h for s in soil], at_nodes([1 / m for m in modulus])
    store = at_nodes([1 / m + p["n"][s] / p["Kw"] for m, s in zip(modulus, soil)])
    load = lambda t: p["q"] * (min(t / p["ramp"], 1.0) if p["ramp"] else 1.0)
    u = [load(0.0) * s / c for s, c in zip(squeeze, store)]  # the undrained pressure
    now, step, count, found = 0.0, 1e-5 * times[0], 0, []
    for time in times:
        while now < time * (1 - 1e-12):
            dt, share = min(step, time - now), 1.0 if count < 4 else 0.5  # first steps damp the jump at the drained end
            a, b, c = [0.0] * (cells + 1), [s / dt for s in store], [0.0] * (cells + 1)
            d = [s * v / dt + q * (load(now + dt) - load(now)) / dt for s, v, q in zip(store, u, squeeze)]
            for e, f in enumerate(flow):
                a[e + 1], c[e], b[e], b[e + 1] = -share * f, -share * f, b[e] + share * f, b[e + 1] + share * f
                d[e], d[e + 1] = d[e] + (1 - share) * f * (u[e + 1] - u[e]), d[e + 1] - (1 - share) * f * (u[e + 1] - u[e])
            for i in [cells] * ("top" in p["drained"]) + [0] * ("bottom" in p["drained"]):
                a[i], b[i], c[i], d[i] = 0.0, 1.0, 0.0, 0.0
            for i in range(1, cells + 1):  # Thomas' algorithm
                b[i], d[i] = b[i] - a[i] / b[i - 1] * c[i - 1], d[i] - a[i] / b[i - 1] * d[i - 1]
            for i in reversed(range(cells + 1)):
                u[i] = (d[i] - (c[i] * u[i + 1] if i < cells else 0.0)) / b[i]
            now, step, count = now + dt, 1.03 * step, count + 1
        found.append((sum(s * (load(time) - v) for s, v in zip(squeeze, u)), u[:]))
    return found


def answer(path, folder, refinement, change=lambda p: None, read=lambda name, v, p, cells: v):  # both plant mistakes
    case, cells, rows = json.loads(pathlib.Path(path).read_text()), int(refinement), []
    change(p := problem(case))
    for name, times in ((wanted["quantity"], wanted["times_s"]) for wanted in case["wanted"]):
        for time, (settlement, u) in zip(times, solve(p, cells, times)):
            values = [("", settlement)] if name == "settlement" else [(i * p["H"] / cells, v) for i, v in enumerate(u)]
            rows += [[refinement, name, time, "", y, read(name, v, p, cells)] for y, v in values]
    with open(pathlib.Path(folder) / "results.csv", "w", newline="") as file:
        csv.writer(file).writerows([["refinement", "quantity", "time_s", "x_m", "y_m", "value"], *rows])


if __name__ == "__main__": answer(*sys.argv[1:4])

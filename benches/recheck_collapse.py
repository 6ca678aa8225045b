"""Rechecks the proof of a collapse: `python3 benches/recheck_collapse.py program.json ...`.

Needs numpy and scipy, and nothing of clastic. It follows the words in the dump and section 9 of
docs/formulation.md, in two ways:

- the mechanism of the dump: it moves nothing that is imposed or has inertia, closes no interaction,
  and the loads do more work along it than the limits can dissipate;
- without the mechanism: a linear program asks for forces s within the limits that balance the
  loads f. It minimises the part t of the loads that stays unbalanced, `G s = (1 - t) f` and
  0 <= t <= 1. A t above 0 proves the collapse. No mechanism has a margin above t.

The exit code is 1 if one of the programs has no valid proof.
"""

import json
import sys

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix, vstack

TOLERANCE = 1e-6  # of section 9


def geometry(program):
    """G by (row of degree of freedom, column 3k + (p, q, tau)), for motions along the body axes."""
    bodies, rows, columns, values = program["bodies"], [], [], []
    cell = program.get("cell")

    def put(body, column, vector, moment):
        x, y = bodies[body]["axis"]
        along = (x * vector[0] + y * vector[1], -y * vector[0] + x * vector[1], moment)
        for k, value in enumerate(along):
            if value != 0.0:
                rows.append(3 * body + k), columns.append(column), values.append(value)

    for k, c in enumerate(program["interactions"]):
        n = np.array(c["normal"])
        t = np.array([-n[1], n[0]])
        a, b = c["a"], c["b"]
        na, nb = c.get("normal_arm_a", 0.0), c.get("normal_arm_b", 0.0)
        put(a, 3 * k, n, na), put(b, 3 * k, -n, nb)
        put(a, 3 * k + 1, t, c["arm_a"]), put(b, 3 * k + 1, -t, c["arm_b"])
        put(a, 3 * k + 2, [0, 0], 1.0), put(b, 3 * k + 2, [0, 0], -1.0)
        image = c.get("image", [0, 0])
        if cell and any(image):
            for column, v in ((3 * k, -n), (3 * k + 1, -t)):
                pull = [image[0] * v[0], image[1] * v[1]]
                put(cell["body"], column, pull, image[1] * cell["arm"] * v[0])
    shape = (3 * len(bodies), 3 * len(program["interactions"]))
    return coo_matrix((values, (rows, columns)), shape=shape).tocsr()


def dofs(program):
    """Loads and the mask of the free degrees of freedom, and whether one has inertia."""
    loads, free, heavy = [], [], []
    for body in program["bodies"]:
        for dof in body["dofs"]:
            is_free = "free" in dof
            free.append(is_free)
            loads.append(dof["free"]["load"] if is_free else 0.0)
            heavy.append(is_free and dof["free"]["inertia"] != 0.0)
    return np.array(loads), np.array(free), np.array(heavy)


def limits(program):
    of = [c["limits"] for c in program["interactions"]]
    names = ("cohesion", "friction", "tension", "rolling", "moment")
    return [np.array([l.get(name, 0.0) for l in of]) for name in names]


def by_mechanism(program, G, u):
    """Margin relative to the work of the loads, and the maximum violation of o >= 0."""
    loads, free, heavy = dofs(program)
    if u[~free].any() or u[heavy].any():
        return -1.0, np.inf
    cohesion, friction, tension, rolling, moment = limits(program)
    closing, slip, turn = (G.T @ u).reshape(-1, 3).T
    slip = np.where((cohesion > 0) | (friction > 0), abs(slip), 0.0)
    turn = np.where((rolling > 0) | (moment > 0), abs(turn), 0.0)
    opening = -closing - friction * slip - rolling * turn
    length = program["scales"]["length"]
    sizes = abs(u.reshape(-1, 3)) * [1.0, 1.0, length]
    with np.errstate(divide="ignore", invalid="ignore"):
        apex = np.where(friction > 0, cohesion / friction, np.inf)
    opens = np.minimum(tension, apex) * np.maximum(opening, 0)
    dissipation = cohesion * slip + moment * turn + opens
    work = loads @ u
    return (work - dissipation.sum()) / work if work > 0 else -1.0, -opening.min() / sizes.max()


def by_program(program, G):
    """Minimum share t of the loads that nothing balances."""
    loads, free, _ = dofs(program)
    cohesion, friction, tension, rolling, moment = limits(program)
    m = len(cohesion)
    force, length = program["scales"]["force"], program["scales"]["length"]
    scale = np.tile([force, force, force * length], m)  # of forces and moments
    rows = np.tile([force, force, force * length], len(loads) // 3)[free]
    A = G[free].multiply(scale).multiply(1.0 / rows[:, None]).tocsr()
    b = loads[free] / rows
    eq = coo_matrix(np.c_[A.toarray(), b])
    i, k = np.arange(m), 3 * np.arange(m)
    inequalities, right = [], []
    for sign in (1.0, -1.0):
        # sign q - slope p <= limit; a moment is in units of force times length.
        shear = (1, friction, cohesion / force)
        for column, slope, limit in (shear, (2, rolling / length, moment / force / length)):
            entries = (np.r_[np.full(m, sign), -slope], (np.r_[i, i], np.r_[k + column, k]))
            row = coo_matrix(entries, shape=(m, 3 * m + 1))
            inequalities.append(row), right.append(limit)
    lower = np.full(3 * m + 1, -np.inf)
    upper = np.full(3 * m + 1, np.inf)
    lower[:-1:3] = -tension / force
    lower[-1], upper[-1] = 0.0, 1.0
    cost = np.zeros(3 * m + 1)
    cost[-1] = 1.0
    found = linprog(cost, A_ub=vstack(inequalities), b_ub=np.concatenate(right), A_eq=eq, b_eq=b,
                    bounds=np.c_[lower, upper], method="highs")
    return found.x[-1] if found.status == 0 else None


def main(paths):
    wrong = False
    for path in paths:
        program = json.load(open(path))
        G = geometry(program)
        certificate = program["solution"]["certificate"]
        t = by_program(program, G)
        bodies, interactions = len(program["bodies"]), len(program["interactions"])
        line = f"{path}: {bodies} bodies, {interactions} interactions; "
        line += f"unbalanced by an LP: {'no answer' if t is None else format(t, '.3e')}"
        proved = t is not None and t > TOLERANCE
        if certificate:
            u = np.array(certificate["mechanism"]).ravel()
            margin, closes = by_mechanism(program, G, u)
            proved &= margin > TOLERANCE and closes < TOLERANCE
            line += f"; mechanism: margin {margin:.3e} ({certificate['margin']:.3e} in the dump)"
            line += f", closes {closes:.1e}"
        else:
            proved, line = False, line + "; no mechanism"
        wrong |= not proved
        print(line, "" if proved else "NOT PROVED")
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

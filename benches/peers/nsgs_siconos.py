"""One frictional problem with the NSGS solver of Siconos, from a dump of clastic; run by `run.py`, or

    python3 nsgs_siconos.py program_000123.json --iterations 100 --iterations 1000

The dump is one increment of rigid disks with friction and inertia, without bonds and rolling
resistance, under Coulomb's law (`--set 'friction_law=Coulomb()' --dump-program N`). With M the
inertia, G the matrix of the balance rows M u + G s = f, e the closing and slip that belong to
imposed motion and s = (p, q), the local problem of Siconos is

    v = W r + b,   W = G' M^-1 G,   b = (g, 0) - G' M^-1 f - e,   r = (p, q), v = (gap, -slip)

where g is the gap at the start, the dump's offset. Errors are those of the motion after the solve, in the
kinetic norm, against the solution of the dump.
"""

import argparse
import json
import math
import time

import numpy as np
import scipy.sparse
import siconos.numerics as sn


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dump")
    parser.add_argument("--iterations", type=int, action="append")
    parser.add_argument("--out", help="JSON for the results")
    options = parser.parse_args()
    with open(options.dump) as f:
        dump = json.load(f)
    problem = Problem(dump)
    rows = [problem.solve(n) for n in options.iterations or [100, 1000, 10000]]
    result = {
        "contacts": problem.contacts,
        "own_violation_m": problem.violation(problem.reference),
        "rows": rows,
    }
    if options.out:
        with open(options.out, "w") as f:
            json.dump(result, f)
    print(json.dumps(result, indent=1))


class Problem:
    """Matrices of the dump."""

    def __init__(self, dump):
        bodies, interactions = dump["bodies"], dump["interactions"]
        place, mass, load = {}, [], []
        fixed = np.zeros((len(bodies), 3))
        for i, body in enumerate(bodies):
            for k, dof in enumerate(body["dofs"]):
                if "free" in dof:
                    d = dof["free"]
                    if d["inertia"] <= 0:
                        raise SystemExit("every free degree of freedom must have inertia")
                    place[i, k] = len(mass)
                    mass.append(d["inertia"])
                    load.append(d["load"])
                else:
                    fixed[i, k] = dof["fixed"]
        self.contacts = len(interactions)
        entries, rows, columns = [], [], []
        known = np.zeros(2 * self.contacts)
        gap = np.zeros(2 * self.contacts)
        self.friction = np.zeros(self.contacts)
        solution = dump["solution"]
        forces = np.array(solution["forces"])
        for c, x in enumerate(interactions):
            limits = x["limits"]
            plain = (
                x["normal_compliance"] == 0
                and x["tangential_compliance"] == 0
                and limits["rolling"] == limits["cohesion"] == limits["tension"] == 0
            )
            if not plain:
                raise SystemExit("contacts must be rigid, unbonded, and without rolling resistance")
            self.friction[c] = limits["friction"]
            n = np.array(x["normal"])
            t = np.array([-n[1], n[0]])
            for body, sign, arm in ((x["a"], 1, x["arm_a"]), (x["b"], -1, x["arm_b"])):
                axis = np.array(bodies[body]["axis"])
                other = np.array([-axis[1], axis[0]])
                g = np.array(
                    [
                        [sign * n @ axis, sign * t @ axis],
                        [sign * n @ other, sign * t @ other],
                        [0.0, arm],
                    ]
                )
                for k in range(3):
                    for j in range(2):
                        if (body, k) in place:
                            rows.append(place[body, k])
                            columns.append(2 * c + j)
                            entries.append(g[k, j])
                        else:
                            known[2 * c + j] += fixed[body, k] * g[k, j]
            gap[2 * c] = x["offset"]
        shape = (len(mass), 2 * self.contacts)
        self.g = scipy.sparse.csr_matrix((entries, (rows, columns)), shape=shape)
        self.mass, self.load = np.array(mass), np.array(load)
        inverse = scipy.sparse.diags(1 / self.mass)
        self.w = (self.g.T @ inverse @ self.g).tocsr()
        self.b = gap - self.g.T @ (self.load / self.mass) - known
        self.reference = forces[:, :2].reshape(-1)
        self.motion = self.displacement(self.reference)

    def displacement(self, r):
        return (self.load - self.g @ r) / self.mass

    def violation(self, r):
        """Greatest violation of Coulomb's law, m: how well forces solve this problem."""
        v = self.w @ r + self.b
        p, q, vn, vt = r[0::2], r[1::2], v[0::2], v[1::2]
        strongest = abs(p).max()
        worst = max(0.0, -vn.min())
        worst = max(worst, (abs(vn) * np.maximum(p, 0)).max() / strongest)
        slack = np.maximum(self.friction * p - abs(q), 0)
        worst = max(worst, (abs(vt) * slack).max() / strongest)
        return worst

    def solve(self, iterations):
        problem = sn.FrictionContactProblem(2, self.contacts, self.matrix(), self.b, self.friction)
        options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = iterations
        options.dparam[sn.SICONOS_DPARAM_TOL] = 1e-14
        r, v = np.zeros(2 * self.contacts), np.zeros(2 * self.contacts)
        # The conversion above is not counted.
        clock, cpu = time.perf_counter(), time.process_time()
        sn.fc2d_driver(problem, r, v, options)
        wall, cpu = time.perf_counter() - clock, time.process_time() - cpu
        difference = self.displacement(r) - self.motion
        norm = lambda u: math.sqrt((self.mass * u * u).sum())
        return {
            "iterations": iterations,
            "wall_s": wall,
            "cpu_s": cpu,
            "violation_m": self.violation(r),
            "error": norm(difference) / norm(self.motion),
            "maximum_error": abs(difference).max() / abs(self.motion).max(),
        }

    def matrix(self):
        """Siconos solves plane problems on sparse matrices of blocks (or on dense ones)."""
        failed, blocks = sn.SBM_from_csparse(2, self.w.tocsc())
        if failed:
            raise SystemExit("Siconos does not take the matrix")
        return blocks


if __name__ == "__main__":
    main()

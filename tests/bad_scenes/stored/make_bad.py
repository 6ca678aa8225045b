"""Makes the bad states of this folder from two_disks.npz. Needs numpy."""
import numpy as np

state = dict(np.load("two_disks.npz"))
np.savez("foreign.npz", temperature=np.array([291.0]))
np.savez_compressed("version_999.npz", **state | {"format": np.array("clastic state 999")})
np.savez_compressed("short.npz", **state | {"state": state["state"][:-1]})
whole = open("two_disks.npz", "rb").read()
open("cut.npz", "wb").write(whole[: len(whole) // 2])

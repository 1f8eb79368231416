"""gymnasium environments (extra `gym`): an agent in the loop of a flight, in place of the inner loop or next to it.

Importing this package registers `uavftc/FaultTolerantAttitude-v0`; so does `gymnasium.make` by itself where the name
of the package stands before it:

    gymnasium.make("uavftc.gym:uavftc/FaultTolerantAttitude-v0")

docs/gym.md says what an agent sees, commands and gets.
"""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

ID = "uavftc/FaultTolerantAttitude-v0"

if ID not in registry:
    register(id=ID, entry_point="uavftc.gym.env:FaultTolerantAttitude", order_enforce=True)

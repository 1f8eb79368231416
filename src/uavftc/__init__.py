"""uavftc: fault-tolerant flight control on JSBSim.

The names below are imported when they are first used, so that `import uavftc` costs nothing.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as typing has it; a command imports nothing before it has seen to Ctrl-C

__version__ = "0.1.0"

_PUBLIC = {
    "fly": "uavftc.api.doors",
    "compare": "uavftc.api.doors",
    "design": "uavftc.api.doors",
    "load": "uavftc.api.doors",
    "sweep": "uavftc.api.campaign",
    "Flight": "uavftc.api.flight",
    "Comparison": "uavftc.api.comparison",
    "Design": "uavftc.api.design",
    "CampaignResult": "uavftc.api.campaign",
    "Scenario": "uavftc.scenario.schema",
    "load_scenario": "uavftc.scenario.load",
    "make_scenario": "uavftc.scenario.load",
    "scenario_text": "uavftc.scenario.load",
    "build_flight": "uavftc.flight.build",
    "fly_to_memory": "uavftc.flight.fly",
    "fly_mission": "uavftc.jobs.fly",
    "metrics_of": "uavftc.analysis.metrics",
    "read_history": "uavftc.results.history",
    "InputError": "uavftc.errors",
}

__all__ = [*_PUBLIC, "__version__"]  # noqa: PLE0604

if TYPE_CHECKING:
    from uavftc.analysis.metrics import metrics_of as metrics_of
    from uavftc.api.campaign import CampaignResult as CampaignResult
    from uavftc.api.campaign import sweep as sweep
    from uavftc.api.comparison import Comparison as Comparison
    from uavftc.api.design import Design as Design
    from uavftc.api.doors import compare as compare
    from uavftc.api.doors import design as design
    from uavftc.api.doors import fly as fly
    from uavftc.api.doors import load as load
    from uavftc.api.flight import Flight as Flight
    from uavftc.errors import InputError as InputError
    from uavftc.flight.build import build_flight as build_flight
    from uavftc.flight.fly import fly_to_memory as fly_to_memory
    from uavftc.jobs.fly import fly_mission as fly_mission
    from uavftc.results.history import read_history as read_history
    from uavftc.scenario.load import load_scenario as load_scenario
    from uavftc.scenario.load import make_scenario as make_scenario
    from uavftc.scenario.load import scenario_text as scenario_text
    from uavftc.scenario.schema import Scenario as Scenario


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> object:
    if name in _PUBLIC:
        import importlib  # noqa: PLC0415

        return getattr(importlib.import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'uavftc' has no attribute '{name}'")

from multisrt.cli.candidates import FAULT_KINDS, PAPERS
from multisrt.cli.run_options import DEFAULT_STRATEGY, FAULTS
from multisrt.presets import PRESETS
from multisrt.spec import CatalogEnvironment, RunSpec


def test_names_for_completion_are_those_of_the_program():
    assert tuple(PRESETS) == PAPERS
    assert RunSpec(environment=CatalogEnvironment(name="open")).strategy == DEFAULT_STRATEGY
    assert all(kind in FAULTS for kind in FAULT_KINDS)

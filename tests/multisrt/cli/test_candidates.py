from multisrt.cli.candidates import FAULT_KINDS, PAPERS
from multisrt.cli.run_options import DEFAULT_STRATEGY, FAULTS
from multisrt.cli.source import keywords_of
from multisrt.environments.catalog import default_parameters, generator_reference, names
from multisrt.presets import PRESETS
from multisrt.spec import CatalogEnvironment, RunSpec
from multisrt.validation_errors import written


def test_names_for_completion_are_those_of_the_program():
    assert tuple(PRESETS) == PAPERS
    assert RunSpec(environment=CatalogEnvironment(name="open")).strategy == DEFAULT_STRATEGY
    assert all(kind in FAULTS for kind in FAULT_KINDS)


def test_parameters_of_generators_are_read_as_they_are():
    for name in names():
        module, _, function = generator_reference(name).partition(":")
        found = keywords_of(module, function) if module else {}
        listed = {key: written(value) for key, value in default_parameters(name)}
        assert list(found) == ([*listed, "seed"] if module else [])
        assert all(found[key].default == default for key, default in listed.items())
    assert keywords_of("multisrt.environments.generators.open", "hall") == {}
    assert keywords_of("multisrt.no_such_module", "hall") == {}

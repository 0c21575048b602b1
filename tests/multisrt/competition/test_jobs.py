import pytest

from multisrt.competition.jobs import STORE, Job, JobResult, JobStore, mean_coverages
from multisrt.geometry.errors import InvalidInputError

RESULT = JobResult(coverage=0.5, decision_s=0.01, wall_s=3.0, replaced=("range_libc",))


def job(robots):
    return Job(map="env1", robots=robots, start=(3, 4), steps=9)


def test_a_half_written_line_is_made_again(tmp_path):
    store = JobStore(tmp_path, "p", "c")
    store.add(job(1), RESULT)
    store.add(job(2), RESULT)
    path = tmp_path / STORE
    path.write_bytes(path.read_bytes()[:-7])
    again = JobStore(tmp_path, "p", "c")
    assert again.results == {job(1): RESULT}
    again.add(job(2), RESULT)
    assert JobStore(tmp_path, "p", "c").results == {job(1): RESULT, job(2): RESULT}


def test_results_of_another_policy_are_kept_and_not_used(tmp_path):
    JobStore(tmp_path, "p", "c").add(job(1), RESULT)
    other = JobStore(tmp_path, "q", "c")
    assert other.results == {}
    other.add(job(2), RESULT)
    assert set(JobStore(tmp_path, "p", "c").results) == {job(1)}


def test_a_file_of_something_else_is_refused(tmp_path):
    (tmp_path / STORE).write_text("{}\n")
    with pytest.raises(InvalidInputError, match="line 1 is not a result"):
        JobStore(tmp_path, "p", "c")


def test_means_are_over_the_starts_of_a_map():
    results = {
        job(1): RESULT,
        Job(map="env1", robots=1, start=(9, 9), steps=9): JobResult(
            coverage=0.7, decision_s=0.0, wall_s=0.0, replaced=()
        ),
        job(2): RESULT,
    }
    assert mean_coverages(results, ["env1"], 1) == pytest.approx([60.0])

"""How often robots decided what."""

from collections import Counter

import multisrt as ms
from multisrt.analysis.decision_counts import Choice, decision_counts, decision_rows
from multisrt.events import Coordinated, Decided, Decision, GoalChosen
from multisrt.reporting.decisions import decision_table
from tests.multisrt.drawing.recordings import A, C, recorded


def decision(time_s, robot, choice="draw"):
    return Decision(
        time_s=time_s, robot=robot, node=(robot, 0), frontier_m=1.0, choice=choice, target=A
    )


def ordered(time_s, robot, order):
    return Coordinated(
        time_s=time_s,
        robot=robot,
        ger=(0, 1),
        master=0,
        feasible=(0,),
        unfeasible=(1,),
        target=A,
        order=order,
        new_target=A,
    )


def told(time_s, robot, text, goal=A):
    return Decided(time_s=time_s, robot=robot, text=text, goal=goal)


def test_decisions_are_counted_with_the_orders_of_masters():
    recording = recorded(
        [A, C],
        [
            decision(0.0, 0),
            decision(0.0, 1),
            ordered(0.5, 1, "wait"),
            ordered(0.6, 1, "keep"),
            decision(1.0, 1),
            decision(2.0, 0, "end"),
        ],
    )
    assert decision_counts(recording) == [
        {Choice("random draw", "no conflict"): 1, Choice("end", "no conflict"): 1},
        {Choice("random draw", "master: wait"): 1, Choice("random draw", "no conflict"): 1},
    ]


def test_own_words_that_differ_in_numbers_are_one_reason():
    recording = recorded(
        [A],
        [
            told(0.0, 0, "nearest of 3, 2.50 m away\nmore"),
            told(1.0, 0, "nearest of 12, 0.7 m away"),
            told(2.0, 0, "nothing left", goal=None),
            told(3.0, 0, "x" * 90),
        ],
    )
    (counts,) = decision_counts(recording)
    assert counts[Choice("goal", "nearest of #, # m away")] == 2
    assert counts[Choice("no goal", "nothing left")] == 1
    assert sum(len(choice.reason) == 60 for choice in counts) == 1


def test_rows_add_up_runs_of_a_strategy():
    runs = [
        ms.explore("open", strategy="minpos", robots=n, seed=seed, max_time_s=40.0).recording
        for n, seed in ((2, 1), (3, 2))
    ]
    rows = decision_rows(runs)
    chosen = [event for run in runs for event in run.of(GoalChosen)]
    assert sum(row.total for row in rows) == len(chosen)
    by_robot = Counter(event.robot for event in chosen)
    for robot in range(3):
        assert sum(row.counts[robot] for row in rows) == by_robot[robot]
    by_reason = Counter(event.because for event in chosen)
    for reason, count in by_reason.items():
        assert sum(row.total for row in rows if row.reason == reason) == count
    (one,) = {len(row.counts) for row in decision_rows(runs, [2])}
    assert one == 1
    assert sum(row.total for row in decision_rows(runs, [2])) == by_robot[2]


def test_tables_are_text_for_other_programs():
    run = ms.explore("open", strategy="minpos", robots=2, seed=1, max_time_s=40.0).recording
    table = decision_table([run])
    head, *lines = table.csv().splitlines()
    assert head == "Strategy,Decision,Reason,Robot 0,Robot 1,All,Share"
    assert sum(int(line.split(",")[5]) for line in lines) == len(run.of(GoalChosen))
    marked = table.markdown().splitlines()
    assert marked[2].count("|") == 8
    table_lines = [line for line in marked if line.startswith("|")]
    assert len(table_lines) == len(lines) + 2
    names = {line.split(",")[k] for line in lines for k in (1, 2)}
    assert {note.partition(": ")[0] for note in table.notes} == names
    assert "start: it had taken its first scan." in marked
    assert "start: it had taken its first scan." in table.latex()
    assert table.latex().count(r"\\") == len(lines) + 1

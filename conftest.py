"""What the examples in docstrings may use without making it: a run, a figure, a directory."""

import signal
from functools import cache

import pytest

# Tests send signals, also to programs that they start. What runs in the background, or after nohup,
# is begun with some of them ignored, and passes that on.
for _name, _usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    _number = getattr(signal, _name, None)
    if _number is not None and signal.getsignal(_number) == signal.SIG_IGN:
        signal.signal(_number, _usual)


@cache
def _run():
    from parkproof.scenario import RunSettings, Scenario, Start
    from parkproof.simulation.run import simulate

    settings = RunSettings(duration=12.0, control_period=0.01, discretisation="implicit")
    start = Start(pose=(-1.0, 0.3, 2.0))
    return simulate(Scenario(title="Example", law="corrected", start=start, run=settings))


@cache
def _lab_run():
    from parkproof.lab.summary import FrameCounts, LabRun, Sample, Setting

    columns = {name: values[::3].tolist() for name, values in _run().trajectory.items()}
    names = {"t": "t", "x0": "x0", "x1": "x1", "psi": "theta", "step": "step"}
    names |= {"v": "v", "omega": "omega"}
    samples = [
        Sample(**{name: columns[column][i] for name, column in names.items()})
        for i in range(len(columns["t"]))
    ]
    return LabRun(
        scenario=Setting(law="corrected", title="Example"),
        outcome=_run().outcome,
        parked=True,
        ended=_run().ended,
        samples=samples,
        frames=FrameCounts(seen=len(samples)),
        latencies=[0.004],
    )


@cache
def _evidence():
    from parkproof.report.evidence import figure_runs, gather

    return gather(figure_runs(("published", "corrected")))


@pytest.fixture(autouse=True)
def _names_of_examples(request, monkeypatch, tmp_path):
    """Give doctests their names, only those they use, and a directory of their own to write in."""
    if not isinstance(request.node, pytest.DoctestItem):
        return
    names = request.getfixturevalue("doctest_namespace")
    text = request.node.dtest.docstring or ""
    monkeypatch.chdir(tmp_path)
    names["directory"] = tmp_path
    if "run)" in text or "run," in text or "run." in text:
        names["run"] = _run()
    if "lab_run" in text:
        names["lab_run"] = _lab_run()
    if "axes" in text or "figure" in text:
        from parkproof.report.style import new_figure

        names["figure"] = new_figure(6.4, 4.0)
        names["axes"] = names["figure"].add_subplot()
    if "console" in text:
        import io

        from rich.console import Console

        names["console"] = Console(file=io.StringIO())
    if ".toml" in text:
        from parkproof.scenario_file import template

        for name in ("gains.toml", "scenario.toml"):
            (tmp_path / name).write_text(template("corrected"), encoding="utf-8")
        (tmp_path / "campaign.toml").write_text(template("campaign"), encoding="utf-8")
    if "evidence" in text:
        from parkproof.report.claims import claims_of

        names["evidence"] = _evidence()
        names["runs"] = _evidence().figures
        names["claims"] = claims_of(_evidence())

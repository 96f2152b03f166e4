"""A printed tag has its scale, its white margin and the right id, and can be mounted by it."""

import re
import shutil
import subprocess
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.lab.tag import TagDetector
from parkproof.lab.tag_sheet import DPI, PAGES, largest_side, tag_cells, tag_sheet


def measured(picture: np.ndarray, dpi: float) -> list[tuple[int, float, tuple[float, float]]]:
    """Id, side in mm and centre in mm from the top left, of all tags on a picture of a page."""
    mm = 25.4 / dpi
    return [
        (seen.tag_id, seen.side * mm, (seen.centre[0] * mm, seen.centre[1] * mm))
        for seen in TagDetector().detect(picture)
    ]


@pytest.mark.parametrize(("tag_id", "side", "page"), [(7, 0.1, "A4"), (586, 0.03, "letter")])
def test_a_printed_tag_is_read_at_its_scale(tag_id: int, side: float, page: str) -> None:
    content = tag_sheet(tag_id, ".png", side=side, page=page)
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    width, height = PAGES[page]
    assert picture.shape == pytest.approx((height / 25.4 * DPI, width / 25.4 * DPI), abs=1.0)
    third = cv2.resize(picture, None, fx=1 / 3, fy=1 / 3, interpolation=cv2.INTER_AREA)
    ((read, size, centre),) = measured(third, DPI / 3)
    assert read == tag_id
    assert size == pytest.approx(1000 * side, abs=0.1)
    assert centre[0] == pytest.approx(width / 2, abs=0.2)


def drawn_by(pdf: bytes) -> np.ndarray:
    """Squares that a PDF fills, drawn at 10 px a mm of an A4 page, black on white."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, flags=re.DOTALL)
    texts = [zlib.decompress(stream) for stream in streams if stream[:1] == b"\x78"]
    page = max(texts, key=lambda text: text.count(b" l\n"))
    number = rb"(-?[\d.]+) (-?[\d.]+)"
    corner = rb" l\n" + number
    square = re.compile(number + rb" m\n" + number + corner + corner + rb" l\n")
    picture = np.full((2970, 2100), 255, np.uint8)
    for found in square.findall(page):
        x = [10 * float(value) * 25.4 / 72 for value in found[0::2]]
        y = [2970 - 10 * float(value) * 25.4 / 72 for value in found[1::2]]
        if max(x) - min(x) > 2000:  # the paper
            continue
        picture[round(min(y)) : round(max(y)), round(min(x)) : round(max(x))] = 0
    return picture


def test_the_pdf_holds_the_tag_in_lines_at_its_scale() -> None:
    pdf = tag_sheet(42, ".pdf", side=0.08)
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", pdf)
    assert box is not None
    assert [float(x) * 25.4 / 72 for x in box.groups()] == pytest.approx([210, 297], abs=0.01)
    half = cv2.resize(drawn_by(pdf), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    ((read, size, _),) = measured(half, 127.0)
    assert read == 42
    assert size == pytest.approx(80.0, abs=0.1)


@pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="needs Debian's poppler-utils")
def test_the_pdf_as_a_viewer_shows_it(tmp_path: Path) -> None:
    file = tmp_path / "tag.pdf"
    file.write_bytes(tag_sheet(42, ".pdf", side=largest_side("A4")))
    command = ["pdftoppm", "-r", "100", "-gray", "-singlefile", str(file), str(tmp_path / "page")]
    subprocess.run(command, check=True)
    ((read, size, _),) = measured(cv2.imread(tmp_path / "page.pgm", cv2.IMREAD_GRAYSCALE), 100.0)
    assert read == 42
    assert size == pytest.approx(1000 * largest_side("A4"), abs=0.3)


def test_the_svg_has_the_size_of_the_page() -> None:
    text = tag_sheet(1, ".svg").decode()
    size = re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', text)
    assert size is not None
    assert [float(x) * 25.4 / 72 for x in size.groups()] == pytest.approx([210, 297], abs=0.01)


def test_the_same_tag_is_the_same_file() -> None:
    for ending in (".pdf", ".svg"):
        assert tag_sheet(3, ending) == tag_sheet(3, ending)


def test_cells_are_those_that_the_detector_reads() -> None:
    for tag_id in (0, 1, 300):
        cells = np.pad(tag_cells(tag_id), 1, constant_values=True)
        picture = np.kron(np.where(cells, 255, 0).astype(np.uint8), np.ones((8, 8), np.uint8))
        (seen,) = TagDetector().detect(np.pad(picture, 20, constant_values=255))
        left_bottom, _, right_top, _ = seen.corners
        assert seen.tag_id == tag_id
        assert left_bottom == pytest.approx((27.5, 91.5), abs=0.3)
        assert right_top == pytest.approx((91.5, 27.5), abs=0.3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--id", "587"], "tag_id = 587: must be an integer from 0 to 586"),
        (["--id", "-1"], "from 0 to 586"),
        (["--side", "0.2"], "A4 has room for tags up to 0.139 m; .*--page A3"),
        (["--side", "1"], "A4 has room .*write a smaller side$"),
        (["--side", "0.001"], "at least 0.005 m"),
        (["--side", "nan"], "finite"),
        (["--page", "B7"], 'page = "B7": must be one of A3, A4, A5, letter'),
        (["--out", "tag.docx"], "tag.docx: a tag can be written as .pdf, .svg, .png"),
        (["--out", "nowhere/tag.pdf"], "no folder nowhere"),
    ],
)
def test_what_cannot_be_printed_is_refused(
    arguments: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["tag", *arguments]) == 2
    assert re.search(words, capsys.readouterr().err.strip())
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_tag_is_kept_unless_told_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["tag", "--id", "7", "--out", "tag.svg"]) == 0
    assert main(["tag", "--id", "8", "--out", "tag.svg"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    before = Path("tag.svg").read_bytes()
    assert main(["tag", "--id", "8", "--out", "tag.svg", "--overwrite"]) == 0
    assert Path("tag.svg").read_bytes() != before
    with pytest.raises(InputError, match="can be written as"):
        tag_sheet(1, ".gif")

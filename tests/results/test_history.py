"""The recorders keep every row once and in order, mark what is missing, and do not grow with the flight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from uavftc.core import signals
from uavftc.errors import InputError
from uavftc.flight.recorder import MemoryRecorder, published
from uavftc.results.history import ParquetRecorder, read_history, read_metadata, write_history

CHUNK = 16_384


def flight(rows: int, first: int = 0) -> np.ndarray:
    """Rows `first` .. of a flight that turns through north every 4 s or so, each field its own number."""
    records = signals.as_records(signals.empty_rows(rows))
    k = np.arange(first, first + rows)
    for i, name in enumerate(signals.ROW.names):
        values = records[name]
        values[...] = i + (k[:, None] if values.ndim == 2 else k) * 1e-3
    records["t"] = k / 200.0
    records["x1"][:, 2] = records["x1_c"][:, 2] = 1.5 * records["t"]
    return records


def write(path: Path, *chunks: np.ndarray, metadata: dict[str, str] | None = None) -> Path:
    with ParquetRecorder(path, metadata or {}) as recorder:
        for chunk in chunks:
            recorder.take(chunk)
    return path


def test_memory_recorder_keeps_each_chunk_without_a_copy():
    # A flight gives each chunk separate memory; copying it would cost 5 % of a flight on JSBSim.
    recorder = MemoryRecorder()
    chunk = flight(10)
    recorder.take(chunk)
    assert np.shares_memory(recorder.records(), chunk)
    recorder.take(flight(5, first=10))

    assert len(recorder.records()) == 15
    np.testing.assert_array_equal(recorder.records()["t"], np.arange(15) / 200.0)
    recorder.take(flight(1, first=15))  # looking must not end the recording
    assert recorder.records()["t"][-1] == 15 / 200.0


def test_memory_recorder_of_no_rows_is_empty_and_typed():
    assert MemoryRecorder().records().dtype == signals.ROW
    assert len(MemoryRecorder().records()) == 0


def test_file_holds_the_published_columns_in_order_with_their_values(tmp_path):
    records = flight(100)
    file = pq.ParquetFile(write(tmp_path / "h.parquet", records[:64], records[64:]))
    with file:
        assert file.schema_arrow.names == [c.name for c in signals.COLUMNS]
        assert file.metadata.num_row_groups == 2  # one a chunk: nothing is kept back
        table = file.read()
    for name in table.column_names:
        np.testing.assert_array_equal(table.column(name).to_numpy(), signals.column(records, name), err_msg=name)


def test_heading_is_continuous_across_chunks_and_turns(tmp_path):
    records = flight(2_000)  # psi reaches 15 rad
    path = write(tmp_path / "h.parquet", records[:777], records[777:])
    psi = read_history(path, ["psi_rad"])["psi_rad"]
    assert np.abs(np.diff(psi)).max() < 0.01


def test_nan_is_null_in_the_file_and_nan_again_when_read(tmp_path):
    records = flight(10)
    records["airspeed"] = np.nan
    records["alpha"][3] = np.nan
    path = write(tmp_path / "h.parquet", records)
    with pq.ParquetFile(path) as file:
        table = file.read()
    assert table.column("airspeed_mps").null_count == 10
    assert table.column("alpha_rad").null_count == 1  # and the nine others are not
    back = read_history(path, ["alpha_rad", "airspeed_mps"])
    assert list(back) == ["alpha_rad", "airspeed_mps"]
    assert np.flatnonzero(np.isnan(back["alpha_rad"])).tolist() == [3]
    assert back["airspeed_mps"].dtype == np.float64
    assert np.isnan(back["airspeed_mps"]).all()


def test_identical_flights_give_identical_bytes_whatever_the_order_of_the_metadata(tmp_path):
    one = write(tmp_path / "1.parquet", flight(5_000), metadata={"seed": "1", "scenario": "name: x\n"})
    two = write(tmp_path / "2.parquet", flight(5_000), metadata={"scenario": "name: x\n", "seed": "1"})
    other = write(tmp_path / "3.parquet", flight(5_000), metadata={"scenario": "name: x\n", "seed": "2"})
    assert one.read_bytes() == two.read_bytes()
    assert one.read_bytes() != other.read_bytes()


def test_a_history_written_at_once_is_the_streamed_one_to_the_byte(tmp_path):
    # a comparison keeps the published columns alone, and its files must be those that the flights would have written
    records, metadata = flight(2_500), {"seed": "1"}
    chunks = [records[k : k + 1_000] for k in range(0, 2_500, 1_000)]
    streamed = write(tmp_path / "streamed.parquet", *chunks, metadata=metadata)
    write_history(tmp_path / "at-once.parquet", published(records), metadata, chunk=1_000)
    assert (tmp_path / "at-once.parquet").read_bytes() == streamed.read_bytes()


def test_metadata_is_kept_under_the_prefix(tmp_path):
    scenario = "name: s\ndescription: angle φ\n"
    path = write(tmp_path / "h.parquet", flight(3), metadata={"scenario": scenario, "seed": "7"})
    with pq.ParquetFile(path) as file:
        assert file.schema_arrow.metadata[b"uavftc.seed"] == b"7"
    assert read_metadata(path) == {"scenario": scenario, "seed": "7"}


def test_memory_stays_bounded_over_an_hour_at_200_hz(tmp_path):
    before = pa.total_allocated_bytes()
    held = []
    with ParquetRecorder(tmp_path / "h.parquet", {}) as recorder:
        chunk = flight(CHUNK)
        for _ in range(44):  # 720 896 rows, 260 MB as published
            recorder.take(chunk)
            held.append(pa.total_allocated_bytes() - before)
    assert max(held[5:]) < 20e6, "more than a few chunks are held"
    assert held[-1] < held[5] + 2e6, "memory grows with the flight"
    with pq.ParquetFile(tmp_path / "h.parquet") as file:
        assert file.metadata.num_rows == 44 * CHUNK


def test_empty_flight_gives_a_readable_file(tmp_path):
    history = read_history(write(tmp_path / "h.parquet", flight(0)))
    assert set(history) == {c.name for c in signals.COLUMNS}
    assert all(values.shape == (0,) for values in history.values())


def test_closing_twice_is_allowed(tmp_path):
    recorder = ParquetRecorder(tmp_path / "h.parquet", {})
    recorder.close()
    recorder.close()


def test_reading_back_equals_publishing(tmp_path):
    records = flight(300)
    back = read_history(write(tmp_path / "h.parquet", records))
    assert list(back) == list(published(records))
    for name, values in published(records).items():
        np.testing.assert_array_equal(back[name], values)


def test_an_unknown_column_a_missing_file_and_a_damaged_file_are_input_errors(tmp_path):
    path = write(tmp_path / "h.parquet", flight(3))
    with pytest.raises(InputError, match="no column phi_deg"):
        read_history(path, ["time_s", "phi_deg"])
    with pytest.raises(InputError, match=r"none\.parquet"):
        read_history(tmp_path / "none.parquet")
    path.write_bytes(path.read_bytes()[:-20])  # as a kill leaves it
    with pytest.raises(InputError, match=r"h\.parquet"):
        read_history(path)

"""Trajectories as tables: omega-prime's columns to CSV and Parquet and back, and plain tables of other tools."""

from engine.interchange.tables.read import read_table
from engine.interchange.tables.write import COLUMNS, write_csv, write_parquet

__all__ = ["COLUMNS", "read_table", "write_csv", "write_parquet"]

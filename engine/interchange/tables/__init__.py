"""Trajectories as tables: omega-prime's columns to CSV and Parquet and back, and plain tables of other people."""

from engine.interchange.tables.omega_prime import COLUMNS, write_csv, write_parquet
from engine.interchange.tables.reading import read_table

__all__ = ["COLUMNS", "read_table", "write_csv", "write_parquet"]

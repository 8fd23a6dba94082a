"""What is looked at during a run: rules, temporal requirements, monitors, records."""

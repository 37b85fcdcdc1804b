"""Write the tables of ``config/README.md``: ``python -m workflow.settings``."""

from workflow.settings.tables import README, updated

if __name__ == "__main__":
    README.write_text(updated(README.read_text(encoding="utf-8")), encoding="utf-8")

"""The library's options of recordings, from the section of the configuration."""

from tepsipe.ingest.recording_options import LoadCell, RecordingOptions, ScaledChannel


def recording_options(section: dict | None) -> RecordingOptions:
    """Options of a file that holds a whole trial; None, of trials of several files, has the defaults."""
    if section is None:
        return RecordingOptions()
    return RecordingOptions(
        forward=section["axes"]["forward"],
        up=section["axes"]["up"],
        plates={belt: tuple(numbers) for belt, numbers in section["plates"].items()},
        load_cells={
            belt: tuple(LoadCell(**{**cell, "position_m": tuple(cell["position_m"])}) for cell in cells)
            for belt, cells in section["load_cells"].items()
        },
        force_sign=section["force_sign"],
        reverse_origin=section["reverse_origin"],
        belt_velocity=_scaled(section["belt_velocity"]),
        velocity_markers=tuple(section["belt_velocity"]["markers"]),
        belt_command=_scaled(section["belt_command"]),
        trigger=section["trigger"],
    )


def _scaled(entry: dict) -> ScaledChannel | None:
    if entry["channel"] is None:
        return None
    return ScaledChannel(entry["channel"], entry["m_per_s_per_unit"], entry["offset"])

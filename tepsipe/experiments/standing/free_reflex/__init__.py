"""The standing person with a free reflex torque: the recommended estimate, its budget and its checks."""

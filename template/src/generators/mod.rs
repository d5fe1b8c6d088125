//! Motions, a file each; `mrroc-new generator --list` shows those of the library, to be copied and changed.{% if task == "empty" %}

mod my_motion;
pub use my_motion::MyMotion; // FILL IN: your step function{% else %}

mod point_to_point;
pub use point_to_point::PointToPoint; // FILL IN: your step function{% endif %}

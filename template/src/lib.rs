//! The task: which robots it is written for, and what the processes of the cell run.

pub mod generators; // {% if levels != "mp" %}
pub mod ecp; // the program of each robot{% endif %}{% if levels != "ecp" %}
pub mod mp; // the program of the coordinator{% endif %}

//! Reports: statistics, figures, tables, templates, provenance. Never simulates.

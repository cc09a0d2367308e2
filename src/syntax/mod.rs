//! TOML to a spanned tree, inheritance, and assignments. Knows nothing about robots.

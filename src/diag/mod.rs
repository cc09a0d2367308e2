//! Diagnostics: what is wrong with a text, where, and how to mend it. Knows nothing but text and spans.

//! The command line: one file per command. Only this module reads arguments.

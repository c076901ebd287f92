//! What the crate and its program promise, seen from outside: a map of behaviours.

mod carriers; // mirrors and glass: closed forms, another renderer, bad input, pictures, saved form factors
mod commands; // what the program writes, prints and answers
mod comparison; // the verdict on right solvers and on wrong ones
mod contacts; // where surfaces touch: nothing leaks, counts hold
mod files; // what scene files mean, and how bad ones are refused
mod form_factor_files; // form factors as CSV, Matrix Market and NumPy files, and the command that writes them
mod form_factors; // closed forms, judged by standard errors
mod hard_cases; // near-singular, tiny, huge, degenerate: every solver, both storages
mod health; // what check finds, on sound scenes and on broken ones
mod lamp_columns; // direct light without bias
mod laws; // furnace, reciprocity, closure, energy, superposition, invariance, an independent reference
mod lights; // lights without area and skies: closed forms, energy, the path tracer, settings
mod linear_elements; // the same rays, less mesh error, and what keeps them stable
mod path_tracer; // closed forms and another renderer, judged by standard errors
mod pictures; // what cameras see: ways of shading agree, nothing lit is black
mod receivers; // light at points that are no patches, and what is reported in lux
mod saved_factors; // what may change around saved form factors, and what may not
mod structure; // modules import only from their left

mod scenes; // small scenes, made on the spot
mod scratch; // a temporary folder for all of them

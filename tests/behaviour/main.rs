//! What the crate and its program promise, seen from outside: a map of behaviours.

mod bright_light; // what a small spot of light sends on
mod carried_light; // lights without area and skies by way of mirrors, metals and glass
mod carriers; // mirrors and glass: closed forms, another renderer, bad input, pictures, saved form factors
mod coincident; // faces in one plane: one order, the same answer as a hair apart
mod coloured_carriers; // mirrors, metals and glass by channel: light paths, energy, saved form factors, receivers
mod commands; // what the program writes, prints and answers
mod comparison; // the verdict on right solvers and on wrong ones
mod contacts; // where surfaces touch: nothing leaks, counts hold
mod convex; // exact form factors where nothing can hide anything
mod darkness; // what light reaches only by leaks, points within solids, answers that tell little
mod effects; // what is lost without an effect, and that nothing else changes
mod environments; // skies from pictures
mod error_bars; // what an answer says of its own error, held against what the error is
mod files; // what scene files mean, and how bad ones are refused
mod form_factor_files; // form factors as CSV, Matrix Market and NumPy files, and the command that writes them
mod form_factors; // closed forms, judged by standard errors
mod gloss; // rough metals: a furnace, light paths, another renderer, pictures
mod hard_cases; // near-singular, tiny, huge, degenerate: every solver, both storages
mod health; // what check finds, on sound scenes and on broken ones
mod ies; // photometric files of luminaires
mod lamp_columns; // direct light without bias
mod laws; // furnace, reciprocity, closure, energy, superposition, invariance, an independent reference
mod lights; // lights without area and skies: closed forms, energy, the path tracer, settings
mod linear_elements; // the same rays, less mesh error, and what keeps them stable
mod media; // glass in water, walls in glass: Snell between solids, a furnace, apparent depth, light paths
mod mutations; // damaged files of every format
mod odd_files; // files as programs write them: encodings, polygons, names, files elsewhere
mod one_sided; // form factors of one side: known values, closure, reciprocity, zeros and their bounds
mod openings; // light that comes in through little
mod path_tracer; // closed forms and another renderer, judged by standard errors
mod pictures; // what cameras see: ways of shading agree, nothing lit is black
mod placement; // lamps, lights and receivers outside, in solids, turned away
mod plan; // what is predicted of effects, patches, bytes, against what comes of it
mod plastic; // a diffuse base under a coat: furnaces, closed forms, light paths, pictures, files
mod random_scenes; // boxes that intersect, touch and coincide under tiny and turned lamps: energy, solvers, error bounds
mod receivers; // light at points that are no patches, and what is reported in lux
mod saved_factors; // what may change around saved form factors, and what may not
mod sheets; // blinds and lampshades: closed forms, energy, every solver, light paths, bad input
mod sidedness; // turned lamps and their backs, lights without area on surfaces
mod slack; // rows that cannot be closed: they fail by themselves, and what they lack is accounted for
mod stopping; // iterations end by light, whatever lamps and rooms; truncated answers say so
mod structure; // modules import only from their left, functions take few parameters
mod study; // accuracy against time: errors that fall, noise that is called noise, studies that resume
mod surroundings; // a wide ground takes few patches from the room on it
mod textures; // pictures on surfaces: averages, light paths, renderings, files
mod thin_glass; // sheets: a slab, a furnace, sun and sky through windows, pictures, settings
mod verdict; // what an answer says of how far it can be relied on, and every fault that must raise it

mod finishes; // what is asked of every finish: a furnace, a lit room, pictures
mod picture_files; // small image files
mod program; // runs the program
mod scenes; // small scenes, made on the spot, and what many tests do with them
mod scratch; // a temporary folder for all of them

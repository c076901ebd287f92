//! What the crate and its program promise, seen from outside: a map of behaviours.

mod structure; // modules import only from their left

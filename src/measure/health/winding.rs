//! Winding: which objects have a front that tells what their surface faces.

use super::edges::Edges;
use crate::patches::seeing_sides;
use crate::trace::Tracer;

/// Why the front of an object is not the side that a form factor should be of, or not the only one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrontDoubt {
    /// Its faces are not wound alike: two that share an edge run it the same way, so that the front goes on
    /// as the back.
    Mixed,
    /// Its fronts provably see nothing, while its backs may: it is probably inside out.
    Blind,
}

/// Per object of the scene, what speaks against taking its front for its outside; nothing where faces that
/// share an edge agree. Sheets and other surfaces with rims do if their faces agree with each other.
pub fn front_doubts(tracer: &Tracer) -> Vec<Option<FrontDoubt>> {
    let scene = tracer.scene();
    let mixed = Edges::new(tracer).broken_objects();
    let mut seeing = vec![[false; 2]; mixed.len()];
    for (face, sees) in scene.faces().iter().zip(seeing_sides(tracer)) {
        let object = &mut seeing[face.object as usize];
        *object = [object[0] | sees[0], object[1] | sees[1]];
    }
    let doubt = |(mixed, sees): (bool, [bool; 2])| match (mixed, sees) {
        (true, _) => Some(FrontDoubt::Mixed),
        (false, [false, true]) => Some(FrontDoubt::Blind),
        _ => None,
    };
    mixed.into_iter().zip(seeing).map(doubt).collect()
}

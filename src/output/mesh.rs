//! Mesh: the patches as coloured triangles, in the PLY format that mesh viewers read.
//!
//! Colours stand at the vertices and are those of [`SmoothField`], constant or linear over each patch; a
//! vertex is shared by the patches of one smooth surface. The back of a face comes as triangles of reversed
//! winding.

use std::io::{self, Write};

use glam::DVec3;
use nalgebra::DMatrix;

use crate::patches::{Basis, Patches};
use crate::render::{Exposure, SmoothField, limited, to_rgb};
use crate::scene::Side;
use crate::trace::Tracer;

/// Coordinates are written as f64 where the scene lies more than so many sizes from the origin, else as f32.
const FAR: f64 = 1e4;

/// Writes the patches with their `radiance` (N × c, N = n or 3n) as exposed sRGB vertex colours: binary PLY,
/// metres.
///
/// # Errors
/// Those of `writer`.
///
/// # Panics
/// If `radiance` has neither n nor 3n rows.
pub fn write_ply(
    writer: &mut dyn Write,
    tracer: &Tracer,
    patches: &Patches,
    radiance: &DMatrix<f64>,
    exposure: Exposure,
) -> io::Result<()> {
    let field = SmoothField::new(tracer, patches, &limited(Basis::of(patches, radiance), radiance));
    let frame = tracer.frame();
    let number =
        if frame.to_world(DVec3::ZERO).length() > FAR * frame.scale() { Number::F64 } else { Number::F32 };
    write_header(writer, patches, &field, exposure, number)?;
    for (point, position) in field.points().iter().enumerate() {
        number.write(writer, frame.to_world(*position))?;
        writer.write_all(&exposure.encode(to_rgb(field.value(point as u32))))?;
    }
    for patch in 0..patches.len() {
        let [a, b, c] = field.corners(patch);
        let corners = if patches.place(patch).side == Side::Front { [a, b, c] } else { [a, c, b] };
        writer.write_all(&[3])?;
        corners.iter().try_for_each(|corner| writer.write_all(&corner.to_le_bytes()))?;
    }
    Ok(())
}

fn write_header(
    writer: &mut dyn Write,
    patches: &Patches,
    field: &SmoothField,
    Exposure { factor }: Exposure,
    number: Number,
) -> io::Result<()> {
    let scene = patches.scene().name().replace(char::is_control, " ");
    let version = env!("CARGO_PKG_VERSION");
    let (vertices, faces, coordinate) = (field.points().len(), patches.len(), number.name());
    write!(
        writer,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment scene {scene}, solved by radiosity {version}; a face per patch, metres\n\
         comment colours are sRGB of radiance (W/sr/m2) times {factor:e}, highlights compressed\n\
         element vertex {vertices}\n\
         property {coordinate} x\n\
         property {coordinate} y\n\
         property {coordinate} z\n\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n\
         element face {faces}\n\
         property list uchar int vertex_indices\n\
         end_header\n"
    )
}

/// How coordinates are written.
#[derive(Clone, Copy)]
enum Number {
    F32,
    F64,
}

impl Number {
    fn name(self) -> &'static str {
        match self {
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    fn write(self, writer: &mut dyn Write, point: DVec3) -> io::Result<()> {
        let coordinates = point.to_array();
        match self {
            Self::F32 => coordinates.iter().try_for_each(|&x| writer.write_all(&(x as f32).to_le_bytes())),
            Self::F64 => coordinates.iter().try_for_each(|x| writer.write_all(&x.to_le_bytes())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::Reach;
    use crate::render::test_scenes::{by_corners, cut, quad, room, triangles};
    use crate::scene::Material;
    use crate::scene::triangle;

    /// Header and body of the mesh of a scene.
    fn written(tracer: &Tracer, patches: &Patches) -> (String, Vec<u8>) {
        let radiance = DMatrix::from_element(patches.len(), 1, 0.5);
        let mut bytes = Vec::new();
        write_ply(&mut bytes, tracer, patches, &radiance, Exposure::default()).unwrap();
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        (String::from_utf8(bytes[..body].to_vec()).unwrap(), bytes[body..].to_vec())
    }

    fn count(header: &str, element: &str) -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element)).unwrap();
        line.trim().parse().unwrap()
    }

    #[test]
    fn the_header_counts_what_follows() {
        let scene = room(Material::lamp("wall", &[0.5], &[1.0]));
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let (header, body) = written(&tracer, &patches);
        let (vertices, faces) = (count(&header, "element vertex"), count(&header, "element face"));
        assert_eq!(faces, patches.len());
        // Four cells along each edge of a wall, and walls share nothing.
        assert_eq!(vertices, 6 * 25);
        assert_eq!(body.len(), vertices * 15 + faces * 13);
        let index = |at: usize| u32::from_le_bytes(body[at..at + 4].try_into().unwrap()) as usize;
        for face in 0..faces {
            let at = vertices * 15 + face * 13;
            assert_eq!(body[at], 3);
            assert!((0..3).all(|k| index(at + 1 + 4 * k) < vertices));
        }
        assert_eq!(body[12..15], Exposure::default().encode([0.5; 3]));
    }

    #[test]
    fn vertices_have_the_colours_of_linear_elements_at_their_place() {
        let wall = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let scene = triangles(&wall, &[0, 0], vec![Material::lamp("wall", &[0.5; 3], &[1.0; 3])]);
        let tracer = Tracer::new(&scene);
        let patches = cut(&tracer, 0.3, Reach::Light);
        let exact = |p: DVec3| DVec3::new(0.1 + 0.3 * p.x, 0.4 - 0.2 * p.y, 0.2 + 0.1 * p.x + 0.2 * p.y);
        let radiance = by_corners(&patches, 3, |_, p| exact(p));
        let mut bytes = Vec::new();
        write_ply(&mut bytes, &tracer, &patches, &radiance, Exposure::default()).unwrap();
        let vertices = 25;
        let body = &bytes[bytes.len() - 13 * patches.len() - 15 * vertices..];
        for vertex in body.chunks_exact(15).take(vertices) {
            let at = |axis: usize| f32::from_le_bytes(vertex[4 * axis..][..4].try_into().unwrap()) as f64;
            let expected = Exposure::default().encode(exact(DVec3::new(at(0), at(1), at(2))).to_array());
            assert_eq!(vertex[12..], expected);
        }
    }

    #[test]
    fn far_from_the_origin_coordinates_keep_their_digits() {
        let far = 1e7 + 1.0 / 3.0;
        let wall = quad([far, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let scene = triangles(&wall, &[0, 0], vec![Material::lamp("wall", &[0.5], &[1.0])]);
        let tracer = Tracer::new(&scene);
        let (header, body) = written(&tracer, &cut(&tracer, 2.0, Reach::Light));
        assert!(header.contains("property double x"));
        let lowest = (0..4).map(|k| f64::from_le_bytes(body[27 * k..27 * k + 8].try_into().unwrap()));
        assert!((lowest.fold(f64::INFINITY, f64::min) - far).abs() < 1e-8);
    }

    #[test]
    fn every_triangle_winds_around_its_own_side() {
        let wall = quad([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let scene = triangles(&wall, &[0, 0], vec![Material::diffuse("wall", &[0.5])]);
        let tracer = Tracer::new(&scene);
        let mut patches = cut(&tracer, 2.0, Reach::Everything);
        patches.activate(&(0..patches.slots() as u32).collect::<Vec<_>>());
        let (header, body) = written(&tracer, &patches);
        let start = count(&header, "element vertex") * 15;
        let vertex = |k: usize| {
            let at =
                |axis: usize| f32::from_le_bytes(body[15 * k + 4 * axis..][..4].try_into().unwrap()) as f64;
            DVec3::new(at(0), at(1), at(2))
        };
        for patch in 0..patches.len() {
            let corner = |k: usize| {
                vertex(u32::from_le_bytes(body[start + 13 * patch + 1 + 4 * k..][..4].try_into().unwrap())
                    as usize)
            };
            let across = triangle::across(&[0, 1, 2].map(corner));
            let place = patches.place(patch);
            assert!(across.dot(tracer.normal(place.face, place.side)) > 0.0);
        }
    }
}

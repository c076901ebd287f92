//! Forecast: what a run will cost in rays, seconds and bytes, told before a ray is traced.
//!
//! Numbers of patches and rays follow from the options, how full the matrix will be from [`Density`]. Seconds
//! are rays × (a + b log₂ faces), and for everything that goes through memory, bytes × passes; the constants
//! were fitted on two cores of an AMD EPYC (Zen) and are divided by the number of threads where work is
//! shared. On another machine they are off by a factor that is about the same for all stages.

use serde::Serialize;

use super::density::Density;
use crate::patches::{Basis, Outlook, PatchError, Tessellation};
use crate::scene::{Feature, Material, Scene, Side};
use crate::trace::{Lamps, Tracer};
use crate::transport::exchange::{MANY, StorageKind};
use crate::transport::form_factors::TraceOptions;
use crate::transport::rows::{BATCHES, RayCount, Shots};
use crate::transport::sources::LightOptions;

/// What something costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Rays.
    pub rays: u64,
    /// Wall-clock time.
    pub seconds: f64,
    /// Bytes held.
    pub bytes: u64,
}

/// How the equation will be solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solving {
    /// By factors where they fit and take a second or two, else by iterations.
    #[default]
    Either,
    /// By factors.
    Factored,
    /// By iterations.
    Iterated,
}

/// What a run is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// How the scene is cut.
    pub tessellation: &'a Tessellation<'a>,
    /// How form factors are traced.
    pub trace: &'a TraceOptions<'a>,
    /// How lights without area are looked for.
    pub light: &'a LightOptions<'a>,
    /// How the equation is solved.
    pub solving: Solving,
    /// The most bytes that factors may take.
    pub memory: u64,
    /// The part of light that may be missing when iterations stop.
    pub tolerance: f64,
    /// The highest order of the series.
    pub order: usize,
    /// Pixels of the picture; 0 for none.
    pub pixels: usize,
}

/// One stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageCost {
    /// Its name, as in `solution.json`.
    pub name: &'static str,
    /// What it costs.
    #[serde(flatten)]
    pub cost: Cost,
}

/// What a run will probably cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Number of patches n.
    pub patches: usize,
    /// Rays per patch.
    pub rays: u32,
    /// Threads that share the work.
    pub threads: usize,
    /// The stages, in the order in which they come.
    pub stages: Vec<StageCost>,
    /// Why rays are needed; nothing where they are not.
    pub(crate) rays_because: Option<String>,
    /// Costs of single effects.
    pub(crate) parts: Parts,
}

/// What single effects cost: what is saved without them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    pub interreflection: Cost,
    pub rows: Cost,
    pub colour: Cost,
    pub back_sides: Cost,
    /// Patches that are backs.
    pub backs: f64,
    pub transmission: Cost,
    pub lamps: Cost,
    pub carriers: Cost,
    pub coats: Cost,
    pub caustics: Cost,
    pub lights: Cost,
    pub sky: Cost,
    pub receivers: Cost,
}

/// Seconds of one thread for a ray through a scene of so many faces, nanoseconds: a, and b for each doubling.
const RAY: [f64; 2] = [30.0, 47.0];
/// The same for a ray that only asks whether something is hidden.
const SHADOW_RAY: [f64; 2] = [40.0, 13.0];
/// Further surfaces that a ray meets once it has met a mirror or glass.
const CARRIERS_MET: f64 = 1.2;
/// Nanoseconds of one thread to sort a landing into the matrix.
const LANDING: f64 = 55.0;
/// Nanoseconds of all threads for a byte of the matrix in one product, of one channel and of several.
const BYTE: [f64; 2] = [0.055, 0.075];
/// Products that balancing takes.
const BALANCING: f64 = 45.0;
const BALANCING_EXACT: f64 = 6.0;
/// Nanoseconds of one thread for the exact exchange area of two patches.
const PAIR: f64 = 80.0;
/// What error bars take, as a part of balancing.
const ERRORS: f64 = 0.6;
/// Multiplications and additions a second of one thread while factoring.
const FACTORING: f64 = 5e10;
/// Nanoseconds to read a face, to build it in, and to write a patch.
const FACE_READ: f64 = 1100.0;
const FACE_BUILT: f64 = 430.0;
const PATCH_WRITTEN: f64 = 5000.0;
/// Nanoseconds of one thread for a pixel, its rays, and how many more of them mirrors and glass make where
/// all see them.
const PIXEL: f64 = 400.0;
const PIXEL_RAYS: f64 = 2.5;
const PIXEL_CARRIED: f64 = 20.0;
/// Rays by which a slot looks around.
const LOOKS: f64 = 20.0;

/// Whether this many factors of N unknowns fit into `memory` and take no more than a second or two.
pub(crate) fn is_quickly_factored(n: usize, factors: usize, memory: u64) -> bool {
    // n³/3 multiplications and additions a factor; two cores do some 10¹¹ of these a second.
    const QUICK: f64 = 1.2e11;
    let (n, factors) = (n as f64, factors as f64);
    factors * n.powi(3) / 3.0 < QUICK && factors * 8.0 * n * n <= memory as f64
}

impl Forecast {
    /// Foretells what `work` costs in a scene: cuts by arithmetic, traces nothing.
    ///
    /// # Errors
    /// `TooManyOverlaps`.
    pub fn new(tracer: &Tracer, work: &Work) -> Result<Self, PatchError> {
        let scene = tracer.scene();
        let outlook = Outlook::new(tracer, work.tessellation.size)?;
        let patches = outlook.patches();
        let n = patches.round() as usize;
        let per_patch = work.trace.rays.unwrap_or(TraceOptions::usual_rays(n)).next_multiple_of(BATCHES);
        let interreflects = !scene.is_without(Feature::Interreflection);
        let without_rays = work.trace.without_rays(tracer, n);
        let is_exact = interreflects && without_rays.is_ok();
        let lamps = Lamps::of_interest(tracer, work.trace.lamp_rays_for(per_patch));
        let lamp_rays = if lamps.is_empty() || is_exact { 0 } else { work.trace.lamp_rays_for(per_patch) };
        let count = RayCount { rays: per_patch, lamp_rays };
        let density = Density::new(tracer, &outlook, &lamps, count, MANY);
        let threads = rayon::current_num_threads();
        let shared = |nanoseconds: f64| 1e-9 * nanoseconds / threads as f64;
        let faces = scene.faces().len();
        let through = |[a, b]: [f64; 2]| a + b * (faces.max(2) as f64).log2();
        let (ray, shadow_ray) = (through(RAY), through(SHADOW_RAY));
        let channels = scene.channels();
        let each = work.trace.basis.coefficients();
        let vector = (8 * each * channels) as f64 * patches;
        let cost =
            |rays: f64, seconds: f64, bytes: f64| Cost { rays: rays as u64, seconds, bytes: bytes as u64 };

        // Rows of rays, and what lies on their way.
        let rays = if interreflects && !is_exact { patches * f64::from(per_patch) } else { 0.0 };
        let exact = if is_exact { shared(0.5 * patches * patches * PAIR) } else { 0.0 };
        let landing_bytes = if work.trace.basis == Basis::Linear { 6.0 } else { 4.0 };
        let rows = cost(rays, shared(rays * ray) + exact, rays * landing_bytes);
        let met = rays * density.carried * CARRIERS_MET;
        let carriers = cost(met, shared(met * ray), 0.0);
        let [coated, turned] = coated_shares(tracer);
        let turned = rays * density.landing * turned;
        let coats = cost(turned, shared(turned * ray), 0.0);
        let pairs = patches * f64::from(lamp_rays);
        let lamp_columns = cost(pairs, shared(pairs * shadow_ray), 0.0);
        let has_caustics = work.trace.caustics == Shots::Shot && tracer.has_carriers() && !lamps.is_empty();
        let shots = if has_caustics { rays / 4.0 } else { 0.0 };
        let lamp_shots = cost(shots, shared(shots * ray * (1.0 + density.carried * CARRIERS_MET)), 0.0);

        // The matrix, and products with it.
        let matrix = match (interreflects, is_exact) {
            (false, _) => 0.0,
            (_, true) => 4.0 * patches * patches,
            _ => matrix_bytes(patches, work.trace, &density),
        };
        let pass = 1e-9 * BYTE[usize::from(channels > 1)] * matrix * 2.0 / threads.clamp(1, 2) as f64;
        let balancing = if is_exact { BALANCING_EXACT } else { BALANCING };
        let balance = cost(0.0, shared(rays * density.landing * LANDING) + balancing * pass, matrix);
        let factors = distinct_reflectances(scene);
        let unknowns = each * n;
        let factored = interreflects
            && match work.solving {
                Solving::Either => is_quickly_factored(unknowns, factors, work.memory),
                Solving::Factored => true,
                Solving::Iterated => false,
            };
        let orders = orders_for(density.reflected, work.tolerance).min(work.order as f64);
        let series = cost(0.0, orders * pass, 3.0 * vector);
        let (factor, solve) = if factored {
            let operations = factors as f64 * (unknowns as f64).powi(3) / 3.0;
            let bytes = 8.0 * factors as f64 * (unknowns as f64).powi(2);
            (cost(0.0, operations / FACTORING / threads as f64, bytes), cost(0.0, 4.0 * pass, 0.0))
        } else {
            // Conjugate gradients need about half as many passes, and bounding the error a few more.
            (Cost::default(), cost(0.0, (0.5 * orders + 8.0) * pass, 5.0 * vector))
        };

        // Error bars count with solving.
        let solve = sum(&[solve, cost(0.0, ERRORS * balance.seconds, 0.0)]);

        // Lights without area, receivers, pictures, files.
        let look = f64::from(work.light.rays);
        let towards = |number: f64| patches * number * (look / 4.0).ceil();
        let to_lights = towards(scene.lights().count() as f64);
        let to_sky = if scene.sky().is_some() { patches * look } else { 0.0 };
        let lights = cost(to_lights, shared(to_lights * shadow_ray), 0.0);
        let sky = cost(to_sky, shared(to_sky * shadow_ray), 0.0);
        // By way of carriers: shots for all patches, and as many rays of theirs into a sky.
        let throws = tracer.has_carriers() && to_lights + to_sky > 0.0;
        let thrown = |kind: bool| if throws && kind { patches * (look / 4.0).ceil() } else { 0.0 };
        let (shots, looks) = (thrown(work.light.caustics == Shots::Shot), thrown(scene.sky().is_some()));
        let carried_light = cost(
            shots + looks,
            shared(ray * (shots * (1.0 + CARRIERS_MET) + looks * (1.0 + density.carried * CARRIERS_MET))),
            9.0 * vector * f64::from(u8::from(throws)),
        );
        let caustics = sum(&[lamp_shots, carried_light]);
        let points: f64 = scene.receivers().iter().map(|receiver| receiver.len() as f64).sum();
        let receivers = cost(points * look, shared(points * look * ray), 0.0);
        let seen = work.pixels as f64 * PIXEL_RAYS * (1.0 + (density.carried + coated) * PIXEL_CARRIED);
        let render = cost(0.0, shared(work.pixels as f64 * PIXEL + seen * ray), work.pixels as f64 * 24.0);
        let around = outlook.slots * LOOKS;

        let [traced, looked] =
            if interreflects { [lamp_columns, Cost::default()] } else { [Cost::default(), lamp_columns] };
        let straight = sum(&[lights, sky, looked]);
        let held = if straight.rays > 0 { vector as u64 } else { 0 };
        let straight = Cost { bytes: held, ..straight };
        let light = sum(&[straight, carried_light]);
        let all = [
            ("load", cost(0.0, 1e-9 * faces as f64 * FACE_READ, 0.0)),
            ("build", cost(0.0, 1e-9 * faces as f64 * FACE_BUILT, 0.0)),
            ("patch", cost(around, shared(around * ray), outlook.slots * 40.0)),
            ("trace", sum(&[rows, carriers, coats, traced, lamp_shots])),
            ("balance", balance),
            ("light", light),
            ("factor", factor),
            ("solve", solve),
            ("series", series),
            ("receive", receivers),
            ("render", render),
            ("write", cost(0.0, 1e-9 * patches * PATCH_WRITTEN, 0.0)),
        ];
        let stages = all.into_iter().filter(|(_, cost)| *cost != Cost::default());
        let interreflection = sum(&[rows, balance, factor, solve, series]);
        let backs: f64 = outlook.patches_of.iter().map(|sides| sides[1]).sum();
        let share = |cost: Cost, part: f64| Cost {
            rays: (cost.rays as f64 * part) as u64,
            seconds: cost.seconds * part,
            bytes: (cost.bytes as f64 * part) as u64,
        };
        let others = share(sum(&[solve, series]), 0.3);
        let parts = Parts {
            interreflection,
            rows,
            colour: if channels > 1 { others } else { Cost::default() },
            back_sides: share(interreflection, backs / patches.max(1.0)),
            backs,
            transmission: share(interreflection, outlook.through_sheets / patches.max(1.0)),
            lamps: lamp_columns,
            carriers,
            coats,
            caustics,
            lights,
            sky,
            receivers,
        };
        Ok(Self {
            patches: n,
            rays: if is_exact || !interreflects { 0 } else { per_patch },
            rays_because: without_rays.err(),
            threads,
            stages: stages.map(|(name, cost)| StageCost { name, cost }).collect(),
            parts,
        })
    }

    /// All stages together: rays, seconds, and the bytes of what is held at once: rays and matrix, or matrix
    /// and factors.
    pub fn total(&self) -> Cost {
        let of = |names: &[&str]| -> u64 {
            self.stages.iter().filter(|s| names.contains(&s.name)).map(|s| s.cost.bytes).sum()
        };
        let bytes = of(&["patch", "balance", "light"])
            + of(&["trace"]).max(of(&["factor", "solve", "series", "render"]));
        Cost { bytes, ..sum(&self.stages.iter().map(|stage| stage.cost).collect::<Vec<_>>()) }
    }
}

/// The part of diffuse surfaces that is coated, and the part of rays, landing anywhere on these, that coats
/// reflect.
fn coated_shares(tracer: &Tracer) -> [f64; 2] {
    if !tracer.has_facets() {
        return [0.0; 2];
    }
    let (mut area, mut shares) = (0.0, [0.0; 2]);
    for face in (0..tracer.scene().faces().len()).filter(|&face| tracer.scene().is_diffuse(face)) {
        let [a, b, c] = *tracer.corners(face);
        let own = (b - a).cross(c - a).length();
        area += own;
        if let Some(coat) = tracer.coat_of(face as u32) {
            shares[0] += own;
            shares[1] += own * (1.0 - coat.passed_of_all());
        }
    }
    shares.map(|share| if area > 0.0 { share / area } else { 0.0 })
}

fn sum(costs: &[Cost]) -> Cost {
    costs.iter().fold(Cost::default(), |sum, cost| Cost {
        rays: sum.rays + cost.rays,
        seconds: sum.seconds + cost.seconds,
        bytes: sum.bytes + cost.bytes,
    })
}

/// Bytes of the matrix, stored as asked for.
fn matrix_bytes(patches: f64, options: &TraceOptions, density: &Density) -> f64 {
    let dense = 4.0 * (patches * options.basis.coefficients() as f64).powi(2);
    match (options.basis, options.storage) {
        (_, StorageKind::Dense) => dense,
        (Basis::Linear, _) => patches * (density.pair_bytes + 24.0),
        (Basis::Constant, StorageKind::Auto) if 12.0 * density.found >= 4.0 * patches => dense,
        (Basis::Constant, _) => patches * 8.0 * (density.entries + 1.0),
    }
}

/// Orders after which the series of a scene that reflects so much has this residual.
fn orders_for(reflected: f64, tolerance: f64) -> f64 {
    let reflected = reflected.clamp(1e-3, 0.999);
    (tolerance.max(1e-15).ln() / reflected.ln()).ceil().max(1.0)
}

/// Number of channels whose reflectances or transmittances differ from those of all before: each is factored
/// by itself.
fn distinct_reflectances(scene: &Scene) -> usize {
    let alike = |a: usize, b: usize| {
        let same = |colour: &[f64]| colour[a] == colour[b];
        let is_alike = |material: &Material| {
            same(material.reflectance_of(Side::Front))
                && same(material.reflectance_of(Side::Back))
                && material.transmittance().is_none_or(same)
        };
        scene.materials().iter().all(is_alike)
    };
    (0..scene.channels()).filter(|&c| (0..c).all(|before| !alike(before, c))).count()
}

//! Forecast: what a run will cost in rays, seconds and bytes, told before it.
//!
//! Numbers of patches and rays follow from the options, how full the matrix will be from [`Density`], and how
//! the sky and lights are looked for from [`Exposure`], which traces a few rays. Seconds are rays × (a + b
//! log₂ faces), and for everything that goes through memory, bytes × passes; the
//! [constants](super::constants) were fitted on one machine and are divided by the number of threads where
//! work is shared. On another machine they are off by a factor that is about the same for all stages.

use serde::Serialize;

use super::constants::{
    AIMED, APERTURE_SEEN, BALANCING, BALANCING_EXACT, BALANCING_NOOKS, BALANCING_VALUE, BYTE, CARRIERS_MET,
    CG_BOUND, CG_PER_ORDER, CG_VECTORS, COARSE, ERRORS, FACE_BUILT, FACE_PARTED, FACE_READ, FACE_SEARCHED,
    FACTORED_PRODUCTS, FACTORING, FULL_ENTRY_BYTES, LANDING, LANDING_BYTES, LANDING_BYTES_LINEAR,
    LEAST_TOLERANCE, LOOKS, MEMORY_THREADS, MOST_WEIGHED, NUMBER_BYTES, OTHER_CHANNELS, PAIR,
    PAIRED_PATCH_BYTES, PASSED_ON, PATCH_WRITTEN, PIXEL, PIXEL_BYTES, PIXEL_CARRIED, PIXEL_RAYS, POINT,
    QUICK, RAY, SERIES_VECTORS, SHADOW_RAY, SHOT_FROM_PLACE, SHOT_ON_ALL, SHOT_THROUGH, SLOT_LOOKS,
    SPARSE_ENTRY_BYTES, SPARSE_FOUND_BYTES, TEXEL, VALUE,
};
use super::density::Density;
use super::exposure::Exposure;
use super::texels::Texels;
use crate::parallel;
use crate::patches::{BYTES_PER_SLOT, Basis, Outlook, PatchError, PatchSize, Reach, Tessellation};
use crate::scene::{Light, Material, Scene, Side, triangle};
use crate::trace::{Lamps, Tracer};
use crate::transport::exchange::{MANY, StorageKind};
use crate::transport::form_factors::TraceOptions;
use crate::transport::rows::{BATCHES, RAYS_PER_SHOT, RayCount, Shots};
use crate::transport::sources::{LightOptions, RAYS_PER_LIGHT_RAY, rays_of, receiver_bytes};

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

/// Whether this many factors of N unknowns fit into `memory` and take no more than a second or two.
pub(crate) fn is_quickly_factored(n: usize, factors: usize, memory: u64) -> bool {
    // n³/3 multiplications and additions a factor.
    let (n, factors) = (n as f64, factors as f64);
    factors * n.powi(3) / 3.0 < QUICK && factors * NUMBER_BYTES * n * n <= memory as f64
}

impl Forecast {
    /// Foretells what `work` costs in a scene: cuts by arithmetic, and traces no more than a few rays.
    ///
    /// # Errors
    /// `TooManyOverlaps`.
    pub fn new(tracer: &Tracer, work: &Work) -> Result<Self, PatchError> {
        let job = Job::new(tracer, work)?;
        let rays = job.rays();
        let matrix = job.matrix(&rays);
        let solving = job.solving(&matrix);
        let lights = job.lights();
        let light = job.direct_light(&rays, &lights);
        let (receivers, render) = (job.receivers(), job.render());
        let [traced, _] = job.lamp_columns(&rays);
        let all = [
            ("load", cost(0.0, 1e-9 * job.faces * FACE_READ, 0.0)),
            ("build", cost(0.0, 1e-9 * job.faces * (FACE_BUILT + job.searched()), 0.0)),
            ("patch", job.cutting()),
            ("trace", sum(&[rays.rows, rays.carriers, rays.coats, traced, rays.lamp_shots])),
            ("balance", matrix.balance),
            ("light", light),
            ("factor", solving.factor),
            ("solve", solving.solve),
            ("series", solving.series),
            ("receive", receivers),
            ("render", render),
            ("write", cost(0.0, 1e-9 * job.patches * PATCH_WRITTEN, 0.0)),
        ];
        let stages = all.into_iter().filter(|(_, cost)| *cost != Cost::default());
        let interreflection =
            sum(&[rays.rows, matrix.balance, solving.factor, solving.solve, solving.series]);
        let backs: f64 = job.outlook.patches_of.iter().map(|sides| sides[1]).sum();
        let share_of_patches = |number: f64| share(interreflection, number / job.patches.max(1.0));
        let others = share(sum(&[solving.solve, solving.series]), OTHER_CHANNELS);
        let parts = Parts {
            interreflection,
            rows: rays.rows,
            colour: if job.channels > 1 { others } else { Cost::default() },
            back_sides: share_of_patches(backs),
            backs,
            transmission: share_of_patches(job.outlook.through_sheets),
            lamps: rays.lamp_columns,
            carriers: rays.carriers,
            coats: rays.coats,
            caustics: sum(&[rays.lamp_shots, lights.carried]),
            lights: lights.lights,
            sky: lights.sky,
            receivers,
        };
        Ok(Self {
            patches: job.number,
            rays: if job.is_exact || !job.interreflects { 0 } else { job.per_patch },
            rays_because: job.without_rays,
            threads: job.threads,
            stages: stages.map(|(name, cost)| StageCost { name, cost }).collect(),
            parts,
        })
    }

    /// All stages together: rays, seconds, and the bytes of what is held at once: rays and matrix, or matrix
    /// and factors.
    pub fn total(&self) -> Cost {
        let bytes_of = |names: &[&str]| -> u64 {
            self.stages.iter().filter(|s| names.contains(&s.name)).map(|s| s.cost.bytes).sum()
        };
        let bytes = bytes_of(&["patch", "balance", "light", "receive"])
            + bytes_of(&["trace"]).max(bytes_of(&["factor", "solve", "series", "render"]));
        Cost { bytes, ..sum(&self.stages.iter().map(|stage| stage.cost).collect::<Vec<_>>()) }
    }
}

/// A cost of so many rays, seconds and bytes.
fn cost(rays: f64, seconds: f64, bytes: f64) -> Cost {
    Cost { rays: rays as u64, seconds, bytes: bytes as u64 }
}

/// A part of a cost.
fn share(cost: Cost, part: f64) -> Cost {
    Cost {
        rays: (cost.rays as f64 * part) as u64,
        seconds: cost.seconds * part,
        bytes: (cost.bytes as f64 * part) as u64,
    }
}

/// What the cost of a job follows from.
struct Job<'a> {
    tracer: &'a Tracer<'a>,
    work: &'a Work<'a>,
    outlook: Outlook,
    density: Density,
    exposure: Exposure,
    /// Triangles of apertures.
    apertures: f64,
    /// Number of patches, and the same as an integer.
    patches: f64,
    number: usize,
    faces: f64,
    channels: usize,
    threads: usize,
    per_patch: u32,
    lamp_rays: u32,
    has_lamps: bool,
    interreflects: bool,
    /// Whether form factors are found without rays; if not, why.
    is_exact: bool,
    without_rays: Option<String>,
    /// Nanoseconds of one thread for a ray, and for one that only asks whether something is hidden.
    ray: f64,
    shadow_ray: f64,
    /// Bytes of one value per coefficient and channel.
    vector: f64,
}

/// What the rays of rows cost, by kind.
struct RayCosts {
    /// Rays of rows.
    traced: f64,
    rows: Cost,
    /// What rays of rows meet on their way.
    carriers: Cost,
    coats: Cost,
    lamp_columns: Cost,
    lamp_shots: Cost,
}

/// What the matrix costs.
struct MatrixCosts {
    /// Seconds of one product with it.
    pass: f64,
    /// Seconds until it closes.
    closing: f64,
    balance: Cost,
}

struct SolvingCosts {
    factor: Cost,
    solve: Cost,
    series: Cost,
}

/// What looking for light that no patch sends out costs.
struct LightCosts {
    lights: Cost,
    sky: Cost,
    /// By way of carriers.
    carried: Cost,
}

impl<'a> Job<'a> {
    fn new(tracer: &'a Tracer, work: &'a Work) -> Result<Self, PatchError> {
        let scene = tracer.scene();
        let outlook = Outlook::new(tracer, work.tessellation.size)?;
        let patches = outlook.patches().round();
        let number = patches as usize;
        let per_patch = work.trace.rays.unwrap_or(TraceOptions::usual_rays(number)).next_multiple_of(BATCHES);
        let interreflects = scene.has_exchange();
        let without_rays = work.trace.without_rays(tracer, number);
        let is_exact = interreflects && without_rays.is_ok();
        let lamps = Lamps::of_interest(tracer, work.trace.lamp_rays_for(per_patch));
        let lamp_rays = if lamps.is_empty() || is_exact { 0 } else { work.trace.lamp_rays_for(per_patch) };
        let count = RayCount { rays: per_patch, lamp_rays };
        let density = Density::new(tracer, &outlook, &lamps, count, MANY);
        let exposure = Exposure::new(tracer, &outlook, &lamps);
        let faces = scene.faces().len();
        let through = |[a, b]: [f64; 2]| a + b * (faces.max(2) as f64).log2();
        let channels = scene.channels();
        Ok(Self {
            tracer,
            work,
            outlook,
            density,
            exposure,
            apertures: tracer.apertures().len() as f64,
            patches,
            number,
            faces: faces as f64,
            channels,
            threads: parallel::threads(),
            per_patch,
            lamp_rays,
            has_lamps: !lamps.is_empty(),
            interreflects,
            is_exact,
            without_rays: without_rays.err(),
            ray: through(RAY),
            shadow_ray: through(SHADOW_RAY),
            vector: NUMBER_BYTES * (work.trace.basis.coefficients() * channels) as f64 * patches,
        })
    }

    /// Seconds of so many nanoseconds of one thread, shared by all.
    fn shared(&self, nanoseconds: f64) -> f64 {
        1e-9 * nanoseconds / self.threads as f64
    }

    /// Nanoseconds for each face in which apertures are looked for.
    fn searched(&self) -> f64 {
        let has_sun = self.tracer.scene().lights().any(|light| matches!(light, Light::Sun { .. }));
        if has_sun || self.tracer.scene().sky().is_some() { FACE_SEARCHED } else { 0.0 }
    }

    /// Slots of the coarse cut that comes before one into a number of patches.
    fn coarse_slots(&self) -> f64 {
        match self.work.tessellation.size {
            PatchSize::Count(count) => {
                self.outlook.slots.min((2.0 * self.faces).max(COARSE.min(count as f64)))
            }
            PatchSize::Edge(_) => 0.0,
        }
    }

    /// Parting faces, and finding the sides that light reaches.
    fn cutting(&self) -> Cost {
        let (slots, coarse) = (self.outlook.slots, self.coarse_slots());
        let cuts = self.outlook.cuts;
        let around = coarse * LOOKS[0] + cuts * slots * LOOKS[1];
        let dark = if self.has_lamps { (slots - self.patches).max(0.0) } else { 0.0 };
        let at_lamps = cuts * dark * f64::from(SLOT_LOOKS);
        let by_looks = around * self.ray + at_lamps * self.shadow_ray + self.faces * FACE_PARTED;
        let all = sum(&[
            cost(around + at_lamps, self.shared(by_looks), slots * BYTES_PER_SLOT as f64),
            self.looking_for_light(cuts * slots + coarse),
            self.shooting_in(),
        ]);
        match self.work.tessellation.reach {
            Reach::Light => all,
            Reach::Everything | Reach::OneSide(_) => {
                cost(0.0, self.shared(self.faces * FACE_PARTED), all.bytes as f64)
            }
        }
    }

    /// Slots that look for the sky and for lights without area.
    fn looking_for_light(&self, slots: f64) -> Cost {
        let (scene, exposure) = (self.tracer.scene(), &self.exposure);
        let looks = slots * exposure.until_lit;
        let to_lights = looks * scene.lights().count() as f64;
        let (to_sky, judged) = match scene.sky() {
            Some(_) if self.apertures > 0.0 => (looks, slots),
            Some(_) => (looks, 0.0),
            None => (0.0, 0.0),
        };
        let [plain, aimed] = exposure.slots.sky;
        let weighed = if plain + aimed > 0.0 { aimed / (plain + aimed) } else { 0.0 };
        let rays = to_lights + to_sky;
        let nanoseconds = rays * self.shadow_ray
            + to_sky * weighed * self.aiming()
            + judged * self.apertures * APERTURE_SEEN;
        cost(rays, self.shared(nanoseconds), 0.0)
    }

    /// Rays of lights and of the sky that are shot into the scene to find what they reach.
    fn shooting_in(&self) -> Cost {
        let scene = self.tracer.scene();
        let cuts = self.outlook.cuts + f64::from(u8::from(self.coarse_slots() > 0.0));
        let placed = scene.lights().filter(|light| light.position().is_some()).count();
        let far = scene.lights().count() - placed + usize::from(scene.sky().is_some());
        let rays =
            far as f64 * (self.apertures * SHOT_THROUGH + SHOT_ON_ALL) + placed as f64 * SHOT_FROM_PLACE;
        cost(cuts * rays, self.shared(cuts * rays * self.ray), 0.0)
    }

    /// Nanoseconds of one thread that a ray into the sky takes more where apertures are weighed.
    fn aiming(&self) -> f64 {
        AIMED[0] + AIMED[1] * self.apertures.min(MOST_WEIGHED)
    }

    /// Rows of rays, and what lies on their way.
    fn rays(&self) -> RayCosts {
        let &Self { patches, ray, .. } = self;
        let trace = self.work.trace;
        let is_traced = self.interreflects && !self.is_exact;
        let rays = if is_traced { patches * f64::from(self.per_patch) } else { 0.0 };
        let exact = if self.is_exact { self.shared(0.5 * patches * patches * PAIR) } else { 0.0 };
        let landing_bytes = if trace.basis == Basis::Linear { LANDING_BYTES_LINEAR } else { LANDING_BYTES };
        let met = rays * self.density.carried * CARRIERS_MET;
        let [_, turned] = coated_shares(self.tracer);
        let turned = rays * self.density.landing * turned;
        let pairs = patches * f64::from(self.lamp_rays);
        let has_caustics = trace.caustics == Shots::Shot && self.tracer.has_carriers() && self.has_lamps;
        let shots = if has_caustics { rays / f64::from(RAYS_PER_SHOT) } else { 0.0 };
        let on_the_way = 1.0 + self.density.carried * CARRIERS_MET;
        RayCosts {
            traced: rays,
            rows: cost(rays, self.shared(rays * ray) + exact, rays * landing_bytes),
            carriers: cost(met, self.shared(met * ray), 0.0),
            coats: cost(turned, self.shared(turned * ray), 0.0),
            lamp_columns: cost(pairs, self.shared(pairs * self.shadow_ray), 0.0),
            lamp_shots: cost(shots, self.shared(shots * ray * on_the_way), 0.0),
        }
    }

    /// The cost of looking at lamps, as columns of the matrix or as direct light.
    fn lamp_columns(&self, rays: &RayCosts) -> [Cost; 2] {
        match self.interreflects {
            true => [rays.lamp_columns, Cost::default()],
            false => [Cost::default(), rays.lamp_columns],
        }
    }

    /// The matrix, and products with it.
    fn matrix(&self, rays: &RayCosts) -> MatrixCosts {
        let bytes = match (self.interreflects, self.is_exact) {
            (false, _) => 0.0,
            (_, true) => FULL_ENTRY_BYTES * self.patches * self.patches,
            _ => matrix_bytes(self.patches, self.work.trace, &self.density),
        };
        let byte = BYTE[usize::from(self.channels > 1)];
        let threads = self.threads.clamp(1, MEMORY_THREADS) as f64;
        let pass = 1e-9 * byte * bytes * MEMORY_THREADS as f64 / threads;
        let whole = self.outlook.stretches.iter().filter(|stretch| stretch.cells <= 1.0).count() as f64;
        let nooks = (2.0 * whole / self.outlook.slots.max(1.0)).min(1.0);
        let balancing = if self.is_exact { BALANCING_EXACT } else { BALANCING + BALANCING_NOOKS * nooks };
        let landing = rays.traced * self.density.landing * LANDING;
        let values = 1e-9 * self.patches * self.work.trace.basis.coefficients() as f64;
        let Texels { partly, wholly } = Texels::new(self.tracer, &self.outlook);
        let averaging = partly * TEXEL[0] + wholly * TEXEL[1];
        let closing = balancing * (pass + BALANCING_VALUE * values);
        let pass = pass + VALUE * values * self.channels as f64;
        MatrixCosts { pass, closing, balance: cost(0.0, self.shared(landing + averaging) + closing, bytes) }
    }

    /// Factors or iterations, the series, and error bars, which count with solving.
    fn solving(&self, matrix: &MatrixCosts) -> SolvingCosts {
        let (pass, work) = (matrix.pass, self.work);
        let factors = distinct_reflectances(self.tracer.scene());
        let unknowns = work.trace.basis.coefficients() * self.number;
        let factored = self.interreflects
            && match work.solving {
                Solving::Either => is_quickly_factored(unknowns, factors, work.memory),
                Solving::Factored => true,
                Solving::Iterated => false,
            };
        let orders = orders_for(self.density.reflected, work.tolerance).min(work.order as f64);
        let (factor, solve) = if factored {
            let operations = factors as f64 * (unknowns as f64).powi(3) / 3.0;
            let bytes = NUMBER_BYTES * factors as f64 * (unknowns as f64).powi(2);
            (
                cost(0.0, operations / FACTORING / self.threads as f64, bytes),
                cost(0.0, FACTORED_PRODUCTS * pass, 0.0),
            )
        } else {
            (Cost::default(), cost(0.0, (CG_PER_ORDER * orders + CG_BOUND) * pass, CG_VECTORS * self.vector))
        };
        SolvingCosts {
            factor,
            solve: sum(&[solve, cost(0.0, ERRORS * matrix.closing, 0.0)]),
            series: cost(0.0, orders * pass, SERIES_VECTORS * self.vector),
        }
    }

    /// Lights without area and the sky.
    fn lights(&self) -> LightCosts {
        let &Self { patches, ray, shadow_ray, .. } = self;
        let (scene, light) = (self.tracer.scene(), self.work.light);
        let look = f64::from(light.rays);
        let looks = self.exposure.patches;
        let to_each = patches * (look / f64::from(RAYS_PER_LIGHT_RAY)).ceil();
        let (to_lights, points) = (to_each * looks.lights, to_each * looks.points);
        // Rays are counted as they are asked for; their time by what patches make of them.
        let [plain, aimed] = looks.sky.map(|rays| patches * look * rays);
        let to_sky = if scene.sky().is_some() { patches * look } else { 0.0 };
        // By way of carriers: shots for all patches, and as many rays of theirs into a sky.
        let throws = self.tracer.has_carriers() && to_lights + to_sky > 0.0;
        let thrown = |kind: bool| {
            if throws && kind { patches * (look / f64::from(RAYS_PER_SHOT)).ceil() } else { 0.0 }
        };
        let (shots, looks) = (thrown(light.caustics == Shots::Shot), thrown(scene.sky().is_some()));
        let on_the_way = looks * (1.0 + self.density.carried * CARRIERS_MET);
        LightCosts {
            lights: cost(
                to_each * scene.lights().count() as f64,
                self.shared(to_lights * shadow_ray + points * POINT),
                0.0,
            ),
            sky: cost(to_sky, self.shared((plain + aimed) * shadow_ray + aimed * self.aiming()), 0.0),
            carried: cost(
                shots + looks,
                self.shared(ray * (shots * (1.0 + CARRIERS_MET) + on_the_way)),
                // The whole, and every batch.
                f64::from(1 + BATCHES) * self.vector * f64::from(u8::from(throws)),
            ),
        }
    }

    /// All of what the stage of this name does.
    fn direct_light(&self, rays: &RayCosts, LightCosts { lights, sky, carried }: &LightCosts) -> Cost {
        let [_, looked] = self.lamp_columns(rays);
        let straight = sum(&[*lights, *sky, looked]);
        let held = if straight.rays > 0 { self.vector as u64 } else { 0 };
        sum(&[Cost { bytes: held, ..straight }, *carried])
    }

    /// Rays around from every point, and as many to what is bright, to each light and to the sky.
    fn receivers(&self) -> Cost {
        let scene = self.tracer.scene();
        let of_receiver =
            |points: usize| points as f64 * f64::from(rays_of(points, self.number, self.work.light.rays));
        let around: f64 = scene.receivers().iter().map(|receiver| of_receiver(receiver.len())).sum();
        let straight = around * (scene.lights().count() + usize::from(scene.sky().is_some())) as f64;
        let seconds = self.shared(2.0 * around * self.ray + straight * self.shadow_ray);
        let bytes = receiver_bytes(scene, self.number, self.work.light.rays);
        cost(2.0 * around + straight, seconds, bytes)
    }

    fn render(&self) -> Cost {
        let [coated, _] = coated_shares(self.tracer);
        let pixels = self.work.pixels as f64;
        let seen = pixels * PIXEL_RAYS * (1.0 + (self.density.carried + coated) * PIXEL_CARRIED);
        cost(0.0, self.shared(pixels * PIXEL + seen * self.ray), pixels * PIXEL_BYTES)
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
        let own = triangle::across(tracer.corners(face)).length();
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
    let dense = FULL_ENTRY_BYTES * (patches * options.basis.coefficients() as f64).powi(2);
    let is_full = SPARSE_FOUND_BYTES * density.found >= FULL_ENTRY_BYTES * patches;
    match (options.basis, options.storage) {
        (_, StorageKind::Dense) => dense,
        (Basis::Linear, _) => patches * (density.pair_bytes + PAIRED_PATCH_BYTES),
        (Basis::Constant, StorageKind::Auto) if is_full => dense,
        (Basis::Constant, _) => patches * SPARSE_ENTRY_BYTES * (density.entries + 1.0),
    }
}

/// Orders after which the series of a scene that reflects so much has this residual.
fn orders_for(reflected: f64, tolerance: f64) -> f64 {
    let reflected = reflected.clamp(PASSED_ON[0], PASSED_ON[1]);
    (tolerance.max(LEAST_TOLERANCE).ln() / reflected.ln()).ceil().max(1.0)
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

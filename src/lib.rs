//! Diffuse global illumination as a matrix problem.
//!
//! Surfaces are cut into patches. Ray-traced form factors F build the transport operator K = diag(ρ) F, and
//! the light that leaves every patch solves the radiosity equation
//!
//! **L = E + K L**, that is **L = (I − K)⁻¹E = E + KE + K²E + …**
//!
//! directly, or as the Neumann series, one bounce of light after another.
//!
//! ```
//! use radiosity::{measure::*, patches::*, reference::*, render, scene::Scene};
//! use radiosity::{solve::*, trace::Tracer, transport::*};
//!
//! # fn main() -> Result<(), radiosity::Error> {
//! let scene = Scene::cornell_box(); // or Scene::load("room.obj")?
//! let tracer = Tracer::new(&scene);
//! let size = PatchSize::Count(800);
//! let mut patches = Patches::new(&tracer, &Tessellation { size, ..Default::default() })?;
//!
//! // Geometry only: no reflectance, no lamp.
//! let factors = FormFactors::trace(&tracer, &mut patches, &TraceOptions::default())?;
//! // One bounce of light, K = diag(ρ) F, and the light E that starts: lamps, lights without area, sky.
//! let problem = Problem::new(&tracer, &patches, &factors, &LightOptions::default())?;
//!
//! // Solve directly, or sum the series bounce by bounce.
//! let exact = problem.direct(&DirectOptions::default())?;
//! let series = problem.neumann(&NeumannOptions { order: 8, ..Default::default() })?;
//! let difference = (&series.solution.radiance - &exact.radiance).amax() / exact.radiance.amax();
//! assert!(difference < series.solution.report.bound);
//!
//! let energy = Energy::of(&problem, &exact.radiance);
//! assert!(energy.imbalance < 1e-12);
//!
//! // Ask an independent witness, who knows its own standard error.
//! let budget = Budget { paths: Some(50_000), ..Default::default() };
//! let truth = PathTracer::new(&tracer).irradiance(&patches, &PathOptions { budget, ..Default::default() })?;
//! let difference = Difference::new(&exact.means().irradiance, &truth);
//! assert!(difference.rms < 0.1 && difference.bias.abs() < 0.02 + 3.0 * difference.bias_error);
//!
//! let camera = render::default_camera(&tracer, &patches);
//! let carried = problem.carried();
//! let options = render::RenderOptions { width: 80, height: 60, carried, ..Default::default() };
//! let picture = render::picture(&tracer, &patches, &exact.radiance, &camera, &options)?;
//! # let folder = tempfile::tempdir().expect("a temporary folder");
//! # let path = folder.path().join("cornell.png");
//! picture.save_png(path, picture.exposure())?;
//! # Ok(())
//! # }
//! ```
//!
//! # Words and units
//!
//! | symbol | name | unit | shape |
//! |---|---|---|---|
//! | L | radiance leaving a patch | W·sr⁻¹·m⁻² | n × c |
//! | Lₑ | emitted radiance | W·sr⁻¹·m⁻² | n × c |
//! | E = Lₑ + ρH₀/π | the right-hand side; Lₑ where there are no lights without area | W·sr⁻¹·m⁻² | n × c |
//! | ρ | reflectance (albedo) | 1 | n × c |
//! | F_ij | form factor: the fraction of what i sends out that lands on j; F_i∞ what escapes | 1 | n × n |
//! | S_ij = A_i F_ij = S_ji | exchange area | m² | n × n |
//! | K = diag(ρ) F | transport operator | 1 | n × n |
//! | H = H₀ + π F L | irradiance | W·m⁻² | n × c |
//! | H₀ | irradiance by lights without area (point, spot, luminaire, sun, sky) | W·m⁻² | n × c |
//! | B = π L | radiosity (radiant exitance) | W·m⁻² | n × c |
//! | Φ = Σ A B | radiant flux (power) | W | c |
//!
//! with n patches and c channels: three of colour, or one where all channels agree. With linear elements
//! ([`Basis::Linear`](patches::Basis)) every patch has three coefficients in the place of one, the field's
//! values at its corners: vectors are 3n × c, S_(ia)(jb) = ∫∫ φ_a φ_b dF dA, and M⁻¹S stands for F, with the
//! mass M_(ia)(ib) = ∫ φ_a φ_b dA; pictures and meshes take either. *Order k* of the series is L_k = Lₑ +
//! ρH_k/π with H_k = H₀ + πF L_{k−1} and L_{−1} = 0; *bounce k* is KᵏE, what order k adds. A *guaranteed*
//! bound holds for the operator at hand in exact arithmetic; it does not speak of how well that operator
//! stands for the scene.
//!
//! Mirrors, metals and glass are no patches: F_ij is what of i's light reaches j straight or by way of them,
//! and F_i∞ has what they absorb beside it. Where they are coloured F differs by channel, see
//! [`FormFactors::exchange_of`](transport::FormFactors::exchange_of).
//!
//! A [sheet](scene::Sheet) lets the part τ of what arrives on either side through to the other: there K = R F
//! with a symmetric 2 × 2 block (ρ_front τ; τ ρ_back) of R in the place of ρ, and row by row L = Lₑ + (ρH +
//! τH′)/π with H′ the irradiance of the other side; see [`Reflection`](transport::Reflection).
//!
//! [Plastic](scene::Surface::Plastic) is a patch, L what its base sends out under the coat: towards an angle
//! of cosine μ there leaves L (1 − E(μ)), and H is the light that gets under the coat over the part of even
//! light that would. Everything above holds with its [étendue](patches::Patches::etendues) A (1 − Ē) in the
//! place of A. In a medium of index of refraction n, such as glass, that is A n², and L, Lₑ and H are given
//! by n²: what refraction leaves as it is.
//!
//! Where a [texture](scene::Texture) varies ρ or Lₑ over a surface, patches have its mean; pictures show the
//! texture itself.
//!
//! A [`Problem`](solve::Problem) joins an operator and the light that starts: of a scene all of it, with
//! [lights without area](scene::Light) and the [sky](scene::Sky), or [other
//! sources](solve::Problem::under) in their place; solutions have H₀ in their irradiance.
//! [`ReceiverRows`](transport::ReceiverRows) give the irradiance at points that are no patches.
//!
//! [`Plan`](transport::Plan) tells which effects a scene calls for; with a [`Forecast`](transport::Forecast)
//! also what each will cost before it is solved. [`Switches`](transport::Switches) leave effects out. A
//! scene that is empty and convex seen from inside ([`Tracer::enclosure`](trace::Tracer::enclosure)) takes no
//! rays: its form factors are exact.
//!
//! # The way through the house
//!
//! Data flows one way, and a module imports only from those to its left:
//! [`parallel`] → [`progress`] → [`scene`] → [`trace`] → [`patches`] → [`transport`] → [`solve`] →
//! [`reference`](mod@reference) → [`measure`] → [`render`] → [`output`].

pub mod measure;
pub mod output;
pub mod parallel;
pub mod patches;
pub mod progress;
pub mod reference;
pub mod render;
pub mod scene;
pub mod solve;
pub mod trace;
pub mod transport;

/// Any error of the library, for programs that do not care which stage it comes from.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// From reading a scene.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// From cutting it into patches.
    #[error(transparent)]
    Patches(#[from] patches::PatchError),
    /// From tracing form factors or making the operator.
    #[error(transparent)]
    Transport(#[from] transport::TransportError),
    /// From solving.
    #[error(transparent)]
    Solve(#[from] solve::SolveError),
    /// From tracing light paths.
    #[error(transparent)]
    Paths(#[from] reference::PathError),
    /// From measuring.
    #[error(transparent)]
    Measure(#[from] measure::MeasureError),
    /// From making a picture.
    #[error(transparent)]
    Render(#[from] render::RenderError),
    /// From writing results.
    #[error(transparent)]
    Output(#[from] output::OutputError),
}

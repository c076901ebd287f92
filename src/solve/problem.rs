//! The radiosity problem L = E + K L of a scene: its operator K, the light E that starts in it, and the ways
//! to its solution.
//!
//! Solvers find the irradiance πFL that surfaces cause; a problem adds H₀, that by lights without area and
//! the sky, and what bright patches bring beside the operator, so that a solution is the light of the whole
//! scene.

use nalgebra::DMatrix;

use super::neumann::neumann_from;
use super::{
    CgOptions, DirectOptions, NeumannOptions, Series, Solution, SolveError, SolveOptions, bounces,
    conjugate_gradients, direct, solve_all,
};
use crate::patches::{Basis, Patches};
use crate::scene::Feature;
use crate::trace::Tracer;
use crate::transport::{FormFactors, LightOptions, Sources, Transport, TransportError};

/// A scene's operator and the light that starts in it. Clones share form factors.
#[derive(Clone, Debug)]
pub struct Problem {
    operator: Transport,
    sources: Sources,
    /// E, N × c.
    right_hand_side: DMatrix<f64>,
}

impl Problem {
    /// The problem of a scene with its own reflectances, sheets, lamps, lights without area and sky; the last
    /// two cost rays. Where the scene is without interreflection, so does the direct light of lamps.
    ///
    /// # Errors
    /// `Unsolvable`, naming the materials of a set of patches that sees only itself and reflects everything;
    /// `Cancelled`.
    pub fn new(
        tracer: &Tracer,
        patches: &Patches,
        factors: &FormFactors,
        options: &LightOptions,
    ) -> Result<Self, TransportError> {
        let unlit = Self::unlit(patches, factors)?;
        let basis = factors.basis();
        let sources = Sources::trace(tracer, patches, basis, options)?;
        Ok(unlit.under(if tracer.scene().is_without(Feature::Interreflection) {
            sources.with_lamps(tracer, patches, basis, options)?
        } else {
            sources.with_bright_light(tracer, patches, &unlit.operator, options)?
        }))
    }

    /// The problem of a scene's reflectances and sheets without any light: what concerns the operator alone,
    /// or waits for [other sources](Problem::under). In a scene without interreflection no light goes from
    /// patch to patch, whatever the form factors.
    ///
    /// # Errors
    /// `Unsolvable`, as [`Problem::new`].
    pub fn unlit(patches: &Patches, factors: &FormFactors) -> Result<Self, TransportError> {
        let none = (!patches.scene().has_exchange()).then(|| FormFactors::none(patches, factors.basis()));
        let operator = Transport::of(none.as_ref().unwrap_or(factors), patches)?;
        let dark = DMatrix::zeros(operator.len(), operator.channels());
        Ok(Self::of(operator, dark))
    }

    /// The problem of any operator and sources, perhaps of emitted radiance (N × c) alone.
    ///
    /// # Panics
    /// If the sources are not of the operator's coefficients and channels.
    pub fn of(operator: Transport, sources: impl Into<Sources>) -> Self {
        let sources = sources.into();
        let right_hand_side = sources.right_hand_side(&operator);
        let shape = (operator.len(), operator.channels());
        assert_eq!(right_hand_side.shape(), shape, "sources are N × c");
        Self { operator, sources, right_hand_side }
    }

    /// The same operator under other sources; costs no ray.
    ///
    /// # Panics
    /// As [`Problem::of`].
    pub fn under(&self, sources: impl Into<Sources>) -> Self {
        Self::of(self.operator.clone(), sources)
    }

    /// The operator K.
    pub fn operator(&self) -> &Transport {
        &self.operator
    }

    /// The form factors that the operator is made of.
    pub fn factors(&self) -> &FormFactors {
        self.operator.factors()
    }

    /// The light that starts in the scene.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// E = Lₑ + ρH₀/π, and what [bright patches](crate::transport::BrightLight) bring beside the operator of
    /// order 1, N × c, W·sr⁻¹·m⁻².
    pub fn right_hand_side(&self) -> &DMatrix<f64> {
        &self.right_hand_side
    }

    /// What starts, order 0 of the series: E without what only order 1 brings, N × c, W·sr⁻¹·m⁻².
    pub fn order_0(&self) -> DMatrix<f64> {
        match &self.sources.bright {
            Some(bright) => &self.right_hand_side - self.operator.reflect(&bright.correction),
            None => self.right_hand_side.clone(),
        }
    }

    /// How light varies over a patch.
    pub fn basis(&self) -> Basis {
        self.operator.basis()
    }

    /// What of H₀ (N × c, W·m⁻²) comes by way of mirrors, metals and glass; none where there is none.
    /// Pictures with gathered light take it.
    pub fn carried(&self) -> Option<&DMatrix<f64>> {
        self.sources.carried.as_ref().map(|light| &light.irradiance)
    }

    /// Solves by the method of the options.
    ///
    /// # Errors
    /// As the solver's own.
    pub fn solve(&self, options: &SolveOptions) -> Result<Solution, SolveError> {
        let solved = super::solve(&self.operator, &self.right_hand_side, options);
        solved.map(|solution| solution.under(&self.sources)).map_err(|error| error.under(&self.sources))
    }

    /// Solves for each of several sources by itself; the direct solver factors once for all.
    ///
    /// # Errors
    /// As the solver's own.
    ///
    /// # Panics
    /// If some sources are not of the operator's coefficients and channels.
    pub fn solve_each(
        &self,
        sources: &[&Sources],
        options: &SolveOptions,
    ) -> Result<Vec<Solution>, SolveError> {
        let right_hand_sides: Vec<_> =
            sources.iter().map(|sources| sources.right_hand_side(&self.operator)).collect();
        let solutions = solve_all(&self.operator, &right_hand_sides.iter().collect::<Vec<_>>(), options)?;
        Ok(solutions.into_iter().zip(sources).map(|(solution, sources)| solution.under(sources)).collect())
    }

    /// Solves with factors of the operator.
    ///
    /// # Errors
    /// `Memory`, `Singular` or `Cancelled`.
    pub fn direct(&self, options: &DirectOptions) -> Result<Solution, SolveError> {
        Ok(direct(&self.operator, options)?.solve(&self.right_hand_side).under(&self.sources))
    }

    /// Solves by conjugate gradients, or by MINRES where sheets let through more than they reflect.
    ///
    /// # Errors
    /// `NotConverged`, with the best iterate, `NotFinite`, or `Cancelled`.
    pub fn conjugate_gradients(&self, options: &CgOptions) -> Result<Solution, SolveError> {
        let solved = conjugate_gradients(&self.operator, &self.right_hand_side, options);
        solved.map(|solution| solution.under(&self.sources)).map_err(|error| error.under(&self.sources))
    }

    /// The first terms of the series by themselves: E, KE, … up to bounce `last`, N × c each; what bright
    /// patches bring beside the operator is in that of bounce 1 and what follows of it.
    pub fn bounces(&self, last: usize) -> Vec<DMatrix<f64>> {
        let k = &self.operator;
        let (Some(bright), 1..) = (&self.sources.bright, last) else {
            return bounces(k, &self.order_0(), last);
        };
        let first = self.order_0();
        let second = k.reflect(&(k.irradiance(&first) + &bright.correction));
        std::iter::once(first).chain(bounces(k, &second, last - 1)).collect()
    }

    /// Sums the Neumann series until it fulfils the [rule](super#tolerance) or reaches its highest order.
    ///
    /// # Errors
    /// `NotFinite` or `Cancelled`.
    pub fn neumann(&self, options: &NeumannOptions) -> Result<Series, SolveError> {
        let (k, e) = (&self.operator, &self.right_hand_side);
        let Series { solution, bounces } = neumann_from(k, e, self.sources.at_order_0(), options)?;
        Ok(Series { solution: solution.under(&self.sources), bounces })
    }
}

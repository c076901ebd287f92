//! Exchange areas of one tone in a file of form factors.

use nalgebra::{DMatrix, DVector};
use sprs::CsMatI;

use super::sections::{Content, FactorsFileError, Section};
use crate::patches::Basis;
use crate::transport::exchange::{Blocks, Closure, Ends, Exchange, ExchangeParts, Storage};
use crate::transport::rows::Landing;

const DENSE: u32 = 0;
const SPARSE: u32 = 1;
const BLOCKS: u32 = 2;

/// One tone's exchange areas.
pub fn write_exchange(exchange: &Exchange, section: &mut Section) {
    let (storage, scale) = exchange.raw();
    match storage {
        Storage::Dense(m) => {
            section.one(DENSE);
            section.list(m.as_slice());
        }
        Storage::Sparse(m) => {
            section.one(SPARSE);
            section.list(&m.proper_indptr().iter().map(|&start| start as u64).collect::<Vec<_>>());
            section.list(m.indices());
            section.list(m.data());
        }
        Storage::Blocks(m) => {
            section.one(BLOCKS);
            m.write(section);
        }
    }
    section.some(scale.as_slice());
    section.some(exchange.ends().leaving.as_slice());
    section.some(exchange.ends().slack.as_slice());
    let in_carriers = exchange.ends().in_carriers.as_ref();
    section.one(u32::from(in_carriers.is_some()));
    in_carriers.into_iter().flatten().for_each(|shares| section.some(shares.as_slice()));
    let Closure { before, after, iterations, slack } = *exchange.closure();
    section.some(&[before, after, slack, exchange.shrinkage()]);
    section.one(iterations as u64);
}

/// What a section says of one tone's exchange areas.
pub fn read_exchange(
    from: &mut Content,
    basis: Basis,
    patches: usize,
) -> Result<ExchangeParts, FactorsFileError> {
    use FactorsFileError::Damaged;
    let n = basis.coefficients() * patches;
    let storage = match from.one::<u32>()? {
        DENSE => {
            let values = from.list::<f32>()?;
            if values.len() != n * n {
                return Err(Damaged);
            }
            Storage::Dense(DMatrix::from_vec(n, n, values))
        }
        SPARSE => {
            let starts = from.list::<u64>()?.into_iter().map(|start| start as usize).collect();
            let (indices, values) = (from.list::<u32>()?, from.list::<f32>()?);
            Storage::Sparse(CsMatI::try_new((n, n), starts, indices, values).map_err(|_| Damaged)?)
        }
        BLOCKS if basis == Basis::Linear => Storage::Blocks(Blocks::read(from, patches)?),
        _ => return Err(Damaged),
    };
    let mut vector = || from.some(n).map(DVector::from_vec);
    let (scale, leaving, slack) = (vector()?, vector()?, vector()?);
    let in_carriers = match from.one::<u32>()? {
        0 => None,
        1 => Some([DVector::from_vec(from.some(n)?), DVector::from_vec(from.some(n)?)]),
        _ => return Err(Damaged),
    };
    let ends = Ends { leaving, in_carriers, slack };
    let [before, after, slack, shrinkage] = [from.one()?, from.one()?, from.one()?, from.one()?];
    let iterations = from.one::<u64>()? as usize;
    let closure = Closure { before, after, iterations, slack };
    Ok(ExchangeParts { storage, scale, ends, closure, shrinkage })
}

impl Blocks {
    /// Adds it to a section of a file.
    fn write(&self, section: &mut Section) {
        let wide = |starts: &[usize]| starts.iter().map(|&start| start as u64).collect::<Vec<_>>();
        section.some(&self.worths);
        section.some(&wide(&self.block_starts));
        section.some(&self.partners);
        section.some(&self.blocks);
        section.some(&wide(&self.landing_starts));
        section.some(&self.landings);
    }

    /// Takes what [`Blocks::write`] added for n patches.
    fn read(from: &mut Content, n: usize) -> Result<Self, FactorsFileError> {
        let starts = |from: &mut Content| -> Result<Vec<usize>, FactorsFileError> {
            let starts = from.some::<u64>(n + 1)?;
            let ascending = starts[0] == 0 && starts.is_sorted() && usize::try_from(starts[n]).is_ok();
            if ascending {
                Ok(starts.into_iter().map(|start| start as usize).collect())
            } else {
                Err(FactorsFileError::Damaged)
            }
        };
        let worths = from.some(n)?;
        let block_starts = starts(from)?;
        let (partners, blocks) = (from.some(block_starts[n])?, from.some(block_starts[n])?);
        let landing_starts = starts(from)?;
        let landings: Vec<Landing> = from.some(landing_starts[n])?;
        let mut all = partners.iter().copied().chain(landings.iter().map(|landing| landing.partner));
        if all.any(|partner: u32| partner as usize >= n) {
            return Err(FactorsFileError::Damaged);
        }
        Ok(Self { worths, block_starts, partners, blocks, landing_starts, landings })
    }
}

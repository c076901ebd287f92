//! Decision: what to try next, from what all steps so far have told.

use super::constants::{
    AIM, CONFIRMATION, LEAST_COST_RATIO, LEAST_COST_RATIO_OF_RAYS, LEAST_OF_LAST, MOST_COST_RATIO,
    MOST_DOUBTFUL, MOST_STEPS, PATCHES_PER_FACE, RAYS_RANGE, RAYS_STEP, SAME_SETTING, TIME_FOR_STEPS,
    WORTHWHILE,
};
use super::forecast::Forecast;
use super::goal::{Ending, Resource, Setting, Tolerated};
use super::search::{Attempt, Choice, Rung, Search};
use crate::measure::Level;
use crate::measure::error_bars::{ErrorPart, slack_at_most};
use crate::transport::{BATCHES, TraceOptions};

/// What to do next.
pub(super) enum Next {
    /// Cut and trace anew.
    Step(Choice),
    /// Add so many rays to each patch.
    MoreRays(u32),
    End(Ending),
}

impl<'s> Search<'_, 's> {
    /// What to do after the last step.
    pub fn next(&mut self, best: &Attempt<'s>) -> Next {
        let now = best.budget.upper95;
        let wanted = self.goal.error.map(|error| match error {
            Tolerated::Relative(share) => share,
            Tolerated::Irradiance(h) => h / best.budget.irradiance.max(f64::MIN_POSITIVE),
        });
        let is_met = wanted.is_none_or(|wanted| now <= wanted && best.patches.len() as f64 >= self.fewest());
        // Finer patches and more rays may cure a doubtful answer, but what some steps did not cure one more
        // will not.
        let tried =
            self.steps.iter().rev().take(MOST_DOUBTFUL).filter(|step| step.verdict > Level::Good).count();
        let is_doubtful = best.verdict.level > Level::Good;
        if is_met
            && (!is_doubtful || tried == MOST_DOUBTFUL)
            && (wanted.is_some() || self.goal.seconds.is_none())
        {
            return Next::End(Ending::Reached);
        }
        let all_time = self.goal.seconds.map_or(f64::INFINITY, |seconds| TIME_FOR_STEPS * seconds);
        let time_left = all_time - self.began.elapsed().as_secs_f64();
        let last = self.steps[self.steps.len() - 1];
        let known = (best.patches.len() as f64, f64::from(best.factors.rays()));
        let insight = best.budget.insight;
        let scatter = self.scatter.iter().sum::<f64>() / self.scatter.len() as f64;
        let slack = slack_at_most(best.budget.part(ErrorPart::SLACK));
        let forecast = Forecast { from: last, power: self.power, insight, scatter, slack, known };
        // Look how many patches the choice has before it is made.
        let (cheapest, choice, lacking) = loop {
            let (cheapest, choice, lacking) = self.choose(&forecast, wanted, time_left);
            let unknown = choice.or(cheapest).filter(|choice| !self.ladder[choice.rung].known);
            let Some(Choice { rung, .. }) = unknown else { break (cheapest, choice, lacking) };
            let rung = &mut self.ladder[rung];
            rung.patches = self.cutter.expected(&best.patches, rung.asked as usize) as f64;
            rung.known = true;
        };
        // What is wanted may take more than there is: then as much of it as there is.
        let short = |of: Resource| match (wanted, cheapest) {
            (None, _) => Ending::Reached,
            _ if is_met => Ending::Doubtful,
            (_, needed) => {
                let nothing = Setting { patches: f64::INFINITY, rays: f64::INFINITY };
                let needed = needed.map_or(nothing, |choice| choice.setting);
                Ending::Short { of, needed, seconds: forecast.seconds(&needed) }
            }
        };
        if self.steps.len() >= MOST_STEPS {
            return Next::End(short(Resource::Effect));
        }
        let Some(Choice { rung, setting }) = choice else {
            return Next::End(short(lacking.unwrap_or(Resource::Time)));
        };
        if let Some(of) = lacking
            && (self.was_tried(&setting) || forecast.upper95(&setting) > WORTHWHILE * now)
        {
            return Next::End(short(of));
        }
        // Towards something far dearer, go half of the way first.
        let leap = forecast.seconds(&setting) / last.seconds;
        if leap > MOST_COST_RATIO && self.steps.len() + 1 < MOST_STEPS {
            let half = (setting.patches * leap.sqrt() / leap).max(last.patches as f64);
            let rung = self.ladder[..rung].iter().rposition(|rung| rung.patches <= half).unwrap_or(rung);
            return Next::Step(Choice { rung, setting });
        }
        match forecast.more_rays(&setting) {
            Some(more) => Next::MoreRays(more as u32),
            None => Next::Step(Choice { rung, setting }),
        }
    }

    /// The cheapest choice that is good enough; the one to make, which is the best that can be had where that
    /// is too dear; and what there is too little of, then.
    fn choose(
        &self,
        forecast: &Forecast,
        wanted: Option<f64>,
        time_left: f64,
    ) -> (Option<Choice>, Option<Choice>, Option<Resource>) {
        let fits = |setting: &Setting| {
            let options = TraceOptions { rays: Some(setting.rays as u32), ..*self.trace };
            options.check(setting.patches as usize).is_ok()
        };
        let affordable = |s: &Setting| fits(s) && forecast.seconds(s) <= time_left;
        let grows = |s: &Setting| {
            let growth =
                if forecast.more_rays(s).is_some() { LEAST_COST_RATIO_OF_RAYS } else { LEAST_COST_RATIO };
            self.steps.len() == 1 || forecast.seconds(s) >= growth * forecast.from.seconds
        };
        let least = |choices: &mut dyn Iterator<Item = Choice>, cost: &dyn Fn(&Setting) -> f64| {
            choices.min_by(|a, b| cost(&a.setting).total_cmp(&cost(&b.setting)))
        };
        let cheapest = wanted.and_then(|wanted| {
            let is_enough = |s: &Setting| grows(s) && forecast.upper95(s) <= AIM * wanted;
            let mut enough = self.choices().filter(|choice| is_enough(&choice.setting));
            least(&mut enough, &|s| forecast.price(s))
        });
        match cheapest {
            Some(choice) if affordable(&choice.setting) => (cheapest, Some(choice), None),
            _ => {
                let too_large = cheapest.is_some_and(|choice| !fits(&choice.setting));
                let lacking = if too_large { Resource::Memory } else { Resource::Time };
                let mut possible = self.choices().filter(|choice| affordable(&choice.setting));
                (cheapest, least(&mut possible, &|s| forecast.upper95(s)), Some(lacking))
            }
        }
    }

    /// All that can be chosen: every number of patches that is believed, but no fewer than were tried last,
    /// with every number of rays.
    fn choices(&self) -> impl Iterator<Item = Choice> {
        let rays = (0..)
            .map(|k| RAYS_RANGE[0] * (RAYS_STEP * f64::from(k)).exp2())
            .take_while(|&rays| rays <= RAYS_RANGE[1]);
        let rays: Vec<f64> =
            rays.map(|rays| (rays / f64::from(BATCHES)).round() * f64::from(BATCHES)).collect();
        let last = self.steps.last().map_or(0.0, |step| step.patches as f64);
        let fewest = self.fewest().max(LEAST_OF_LAST * last);
        let rungs = self.ladder.iter().enumerate().filter(move |(_, rung)| rung.patches >= fewest);
        rungs.flat_map(move |(rung, &Rung { patches, .. })| {
            rays.clone().into_iter().map(move |rays| Choice { rung, setting: Setting { patches, rays } })
        })
    }

    /// The fewest patches of a cut that is believed.
    fn fewest(&self) -> f64 {
        let scene = self.tracer.scene();
        let faces = (0..scene.faces().len()).filter(|&face| scene.is_diffuse(face)).count();
        let first = self.steps.first().map_or(0.0, |step| step.patches as f64);
        (PATCHES_PER_FACE * faces as f64).min(CONFIRMATION * first)
    }

    fn was_tried(&self, setting: &Setting) -> bool {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < SAME_SETTING;
        self.steps
            .iter()
            .any(|s| near(setting.patches, s.patches as f64) && near(setting.rays, s.rays.into()))
    }
}

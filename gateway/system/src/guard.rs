//! Bounds of what a component in a thread of its own may learn.

use crate::component::Component;

/// How far the estimates of a component may lie from their first values.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Largest |p.x - p0.x| / scale.x of every output `p.x` with these parameters.
    pub range: f64,
    /// Largest |innovation[k]|; 0: not judged.
    pub innovation: f64,
}

/// The first output that left its bounds. From then on the component learns no more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frozen {
    /// Place among the outputs of the component.
    pub output: usize,
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// Base step.
    pub now: i64,
}

/// Lowest and highest value of each output, and whether it is an innovation.
pub(crate) struct Guard(Vec<(f64, f64, bool)>);

impl Guard {
    /// `outputs`: names without the component.
    pub fn new(component: &Component, outputs: &[String], bounds: Option<Bounds>) -> Guard {
        let free = (f64::NEG_INFINITY, f64::INFINITY, false);
        let of = |name: &String| {
            let Some(bounds) = bounds else { return free };
            if name.starts_with("innovation[") && bounds.innovation > 0.0 {
                return (-bounds.innovation, bounds.innovation, true);
            }
            let parameter = |kind: &str| {
                let element = name.strip_prefix("p.")?;
                component.parameter(&format!("{kind}.{element}"))
            };
            match (parameter("p0"), parameter("scale")) {
                (Some(p0), Some(scale)) => {
                    let far = bounds.range * scale.abs();
                    (p0 - far, p0 + far, false)
                }
                _ => free,
            }
        };
        Guard(outputs.iter().map(of).collect())
    }

    /// Shares of the bounds that values take: of the estimates, and of the innovations.
    pub fn shares(&self, values: &[f64]) -> [f64; 2] {
        let mut most = [0.0f64; 2];
        for (value, (low, high, innovation)) in values.iter().zip(&self.0) {
            let (middle, far) = (0.5 * (low + high), 0.5 * (high - low));
            if far.is_finite() && far > 0.0 {
                let most = &mut most[usize::from(*innovation)];
                *most = most.max(((value - middle) / far).abs());
            }
        }
        most
    }

    /// The first value outside; one that is not finite is another fault.
    pub fn outside(&self, values: &[f64], now: i64) -> Option<Frozen> {
        let mut all = values.iter().zip(&self.0).enumerate();
        all.find(|(_, (value, (low, high, _)))| **value < *low || **value > *high).map(
            |(output, (value, (low, high, _)))| Frozen {
                output,
                value: *value,
                low: *low,
                high: *high,
                now,
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_beyond_either_bound_is_told_and_nan_is_not() {
        let guard = Guard(vec![
            (f64::NEG_INFINITY, f64::INFINITY, false),
            (-1.0, 2.0, false),
            (0.0, 1.0, true),
        ]);
        assert_eq!(guard.shares(&[1e300, -0.25, 0.75]), [0.5, 0.5]);
        assert_eq!(guard.outside(&[1e300, 2.0, 0.0], 7), None);
        assert_eq!(guard.outside(&[f64::NAN, f64::NAN, 1.0], 7), None);
        for value in [-1.1, 2.1] {
            let fault = guard.outside(&[0.0, value, 9.0], 7).unwrap();
            assert_eq!((fault.output, fault.value, fault.now), (1, value, 7));
            assert_eq!((fault.low, fault.high), (-1.0, 2.0));
        }
    }
}

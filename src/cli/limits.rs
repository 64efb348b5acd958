//! Priors and bounds of intrinsics, as a user writes them.

use crate::bundle::{Bound, Of, Prior};
use crate::scene::CameraId;

/// `[CAMERA:]NAME=MEAN+-STD`
pub(super) fn prior(text: &str) -> Result<Prior, String> {
    let (of, value) = of(text)?;
    let parts = value.split_once("+-").or_else(|| value.split_once('±'));
    let (mean, std) = parts.ok_or_else(|| format!("`{value}` is not MEAN+-STD"))?;
    let (mean, std) = (number(mean)?, number(std)?);
    if !(mean.is_finite() && std > 0.0 && std.is_finite()) {
        return Err(format!("`{value}` is not a mean with a std above 0"));
    }
    Ok(Prior { of, mean, std })
}

/// `[CAMERA:]NAME=LEAST..MOST`, of which one may be left out
pub(super) fn bound(text: &str) -> Result<Bound, String> {
    let (of, value) = of(text)?;
    let (least, most) =
        value.split_once("..").ok_or_else(|| format!("`{value}` is not LEAST..MOST"))?;
    let end = |text: &str, open| if text.trim().is_empty() { Ok(open) } else { number(text) };
    let (least, most) = (end(least, f64::NEG_INFINITY)?, end(most, f64::INFINITY)?);
    if least >= most || least.is_nan() || most.is_nan() {
        return Err(format!("`{value}` holds no range; to hold a value leave it out of --refine"));
    }
    Ok(Bound { of, least, most })
}

fn of(text: &str) -> Result<(Of, &str), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| format!("`{text}` has no `=`"))?;
    let (camera, name) = match name.split_once(':') {
        Some((id, name)) => {
            let id = id.trim().parse().map_err(|_| format!("`{id}` is not the id of a camera"))?;
            (Some(CameraId(id)), name)
        }
        None => (None, name),
    };
    let name = name.trim().to_owned();
    if name.is_empty() {
        return Err("a name is missing".to_owned());
    }
    Ok((Of { camera, name }, value))
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("`{text}` is not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priors_and_bounds_are_read_as_they_are_written() {
        let of = |camera: Option<u32>, name: &str| Of {
            camera: camera.map(CameraId),
            name: name.to_owned(),
        };
        let read = prior("fx=800+-5").unwrap();
        assert_eq!(read, Prior { of: of(None, "fx"), mean: 800.0, std: 5.0 });
        assert_eq!(prior("fx = 800 ± 5").unwrap(), read);
        let read = prior("2:k1=-1e-2+-1e-3").unwrap();
        assert_eq!(read, Prior { of: of(Some(2), "k1"), mean: -0.01, std: 0.001 });
        let read = bound("k1=-0.5..0.5").unwrap();
        assert_eq!(read, Bound { of: of(None, "k1"), least: -0.5, most: 0.5 });
        let read = bound("3:k1=..0").unwrap();
        assert_eq!(read, Bound { of: of(Some(3), "k1"), least: f64::NEG_INFINITY, most: 0.0 });
    }

    #[test]
    fn what_says_nothing_is_refused() {
        for text in ["fx", "fx=800", "fx=800+-0", "fx=800+--1", "=1+-1", "x:fx=1+-1", "fx=nan+-1"] {
            assert!(prior(text).is_err(), "{text}");
        }
        for text in ["k1", "k1=0.5", "k1=1..0", "k1=0..0", "k1=a..b", "k1=nan..1"] {
            assert!(bound(text).is_err(), "{text}");
        }
    }
}

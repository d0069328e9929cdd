//! WAV: samples as shares of full scale.

use hound::{SampleFormat, WavReader};

use super::{Channel, Found, Trouble};

pub fn read(bytes: &[u8]) -> Result<Found, Trouble> {
    let damaged = |error: hound::Error| Trouble::damaged(format!("not a whole WAV file ({error})"));
    let mut reader = WavReader::new(bytes).map_err(damaged)?;
    let spec = reader.spec();
    let count = usize::from(spec.channels);
    if count == 0 || spec.sample_rate == 0 {
        return Err(Trouble::damaged(format!(
            "{count} channels at {} Hz are announced",
            spec.sample_rate
        )));
    }
    let announced = reader.duration() as usize;
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); count];
    let mut put = |at: usize, value: f64| values[at % count].push(value);
    match spec.sample_format {
        SampleFormat::Float => {
            for (at, sample) in reader.samples::<f32>().enumerate() {
                put(at, f64::from(sample.map_err(damaged)?));
            }
        }
        SampleFormat::Int => {
            let full = 2f64.powi(i32::from(spec.bits_per_sample) - 1);
            for (at, sample) in reader.samples::<i32>().enumerate() {
                put(at, f64::from(sample.map_err(damaged)?) / full);
            }
        }
    }
    if let Some(short) = values.iter().find(|v| v.len() < announced) {
        return Err(Trouble::damaged(format!(
            "{announced} samples are announced and {} are there",
            short.len()
        )));
    }
    let channels = values.into_iter().enumerate().map(|(i, values)| Channel {
        even: Some((0.0, f64::from(spec.sample_rate))),
        strange_unit: Some("full scale".to_owned()),
        ..Channel::new(&format!("channel{}", i + 1), values)
    });
    Ok(Found {
        channels: channels.collect(),
        ..Found::default()
    })
}

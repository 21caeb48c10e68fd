//! Light on the figure: a key light, the sky, what the floor throws back, and a rim from behind.

use glam::Vec3;

/// Colours are linear RGB, in units of what a white surface sends back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Unit vector towards the key light.
    pub key_direction: Vec3,
    /// The key light.
    pub key_colour: Vec3,
    /// From above.
    pub sky_colour: Vec3,
    /// From below.
    pub bounce_colour: Vec3,
    /// Along edges that turn away from the key light.
    pub rim_colour: Vec3,
}

impl Environment {
    /// A soft box, high, to the left of the figure's front, low enough that it grazes the cloth.
    pub const STUDIO: Self = Self {
        key_direction: Vec3::new(-0.522_956_4, 0.665_580_9, 0.532_464_7),
        key_colour: Vec3::new(2.3, 2.219_5, 2.093),
        sky_colour: Vec3::new(0.688, 0.752, 0.864),
        bounce_colour: Vec3::new(0.52, 0.494, 0.468),
        rim_colour: Vec3::new(0.522_5, 0.539, 0.577_5),
    };
    /// A clear day: high sun, blue sky.
    pub const DAYLIGHT: Self = Self {
        key_direction: Vec3::new(0.371_375_3, 0.835_594_4, 0.404_799_1),
        key_colour: Vec3::new(2.75, 2.62, 2.38),
        sky_colour: Vec3::new(0.62, 0.80, 1.10),
        bounce_colour: Vec3::new(0.50, 0.48, 0.42),
        rim_colour: Vec3::new(0.40, 0.46, 0.58),
    };
    /// A low, warm sun from the side.
    pub const SUNSET: Self = Self {
        key_direction: Vec3::new(0.802_948_8, 0.353_297_5, 0.480_056_3),
        key_colour: Vec3::new(3.0, 1.85, 0.95),
        sky_colour: Vec3::new(0.48, 0.46, 0.72),
        bounce_colour: Vec3::new(0.44, 0.33, 0.27),
        rim_colour: Vec3::new(0.85, 0.52, 0.36),
    };
    /// A cool, dim light and a bright rim.
    pub const NIGHT: Self = Self {
        key_direction: Vec3::new(-0.573_527_7, 0.737_392_8, 0.356_816_2),
        key_colour: Vec3::new(0.72, 0.90, 1.30),
        sky_colour: Vec3::new(0.16, 0.20, 0.34),
        bounce_colour: Vec3::new(0.08, 0.09, 0.13),
        rim_colour: Vec3::new(0.75, 0.90, 1.25),
    };

    /// The presets by name.
    pub const PRESETS: [(&str, Self); 4] =
        [("studio", Self::STUDIO), ("daylight", Self::DAYLIGHT), ("sunset", Self::SUNSET), ("night", Self::NIGHT)];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn key_lights_come_from_above_by_unit_vectors() {
        for (name, environment) in Environment::PRESETS {
            let direction = environment.key_direction;
            assert!((direction.length() - 1.0).abs() < 1e-5 && direction.y > 0.3, "{name}: {}", direction.length());
        }
    }

    #[test]
    fn presets_differ() {
        for (i, (name, environment)) in Environment::PRESETS.iter().enumerate() {
            assert!(Environment::PRESETS[..i].iter().all(|(_, other)| other != environment), "{name}");
        }
    }
}

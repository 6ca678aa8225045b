//! Particles that a scene lists one by one.

use crate::common::random::Random;
use crate::sample::{Sample, digits};

/// A particle. The name of its group is empty where it has none.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
    pub group: &'static str,
}

/// The grains of a sample on a loose grid above `base` (m), each at a random place in its cell; and
/// the top of the grid (m).
pub fn grid(sample: &Sample, width: f64, base: f64, random: &mut Random) -> (Vec<Disk>, f64) {
    let spacing = sample.spacing();
    let columns = (width / spacing).floor() as u32;
    let origin = 0.5 * (width - f64::from(columns) * spacing);
    let disks = (0..sample.count)
        .map(|k| {
            let x = origin + spacing * (f64::from(k % columns) + 0.5);
            let y = base + spacing * (f64::from(k / columns) + 0.5);
            grain(sample, x, y, random)
        })
        .collect();
    (disks, base + spacing * f64::from(sample.count.div_ceil(columns)))
}

/// A grain of the sample at a random place in the cell with centre (x, y).
pub fn grain(sample: &Sample, x: f64, y: f64, random: &mut Random) -> Disk {
    let radius = digits(sample.sizes.radius(random), 4);
    let room = 0.5 * sample.spacing() - radius;
    let mut shift = || random.between(-room, room);
    Disk { x: x + shift(), y: y + shift(), radius, group: "" }
}

/// Area of the disks, m².
pub fn area(disks: &[Disk]) -> f64 {
    disks.iter().map(|d| std::f64::consts::PI * d.radius * d.radius).sum()
}

/// The specimen as the scene writes it.
pub fn listed(disks: &[Disk]) -> String {
    let row = |d: &Disk| {
        let group =
            if d.group.is_empty() { String::new() } else { format!(", group: {:?}", d.group) };
        let (x, y) = (digits(d.x, 7), digits(d.y, 7));
        format!("        (position: ({x:?}, {y:?}), radius: {:?}{group}),\n", d.radius)
    };
    format!("Particles([\n{}    ])", disks.iter().map(row).collect::<String>())
}

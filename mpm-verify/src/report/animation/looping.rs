//! The failure as a small image that loops: an animated PNG of few colours, of which each frame holds what changed.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use plotters::prelude::{BitMapBackend, IntoDrawingArea, RGBColor};

use super::TANK;
use super::chosen::{IMAGE, chosen};
use crate::frames::Shot;
use crate::report::numbers::short;
use crate::report::plots::canvas::{BITMAP_LETTERS, Canvas, DrawError, Drawn, LEFT, MIDDLE, RIGHT, Rect};
use crate::report::plots::levee::map::Window;
use crate::report::plots::levee::{Event, Site, clock, map};
use crate::report::plots::look::{BLACK, BLUE, Dash, GREY, Look, Marker, POOL, SAND, WHITE};
use crate::report::plots::ready;
use crate::report::quantity::STRAIN;
use crate::report::{ReportError, unwritable};

/// Width of the image, px.
const WIDTH: f64 = 720.0;
/// Edges of the map, px from the left, the right and the top.
const EDGES: [f64; 3] = [34.0, 12.0, 60.0];
/// Room below the map, px: ticks, then the legend.
const BELOW: f64 = 66.0;
/// Time that a frame of seepage, a frame of moving soil, the first and the last frame are shown, ms.
const SHOWN_MS: [u16; 4] = [90, 110, 700, 3500];
/// Soil below the water level.
const WET: RGBColor = RGBColor(116, 169, 214);
/// Colours of strain above and below the water, with the share of the range where they are reached.
const RAMPS: [[(f64, RGBColor); 3]; 2] = [
    [(0.4, RGBColor(238, 138, 52)), (0.7, RGBColor(206, 50, 32)), (1.0, RGBColor(110, 8, 46))],
    [(0.4, RGBColor(150, 92, 178)), (0.7, RGBColor(158, 30, 110)), (1.0, RGBColor(84, 0, 50))],
];
/// Colours of strain told apart.
const SHADES: usize = 24;
/// The place in the palette of a pixel that stays as it was.
const SAME: u8 = 255;

/// Writes the image.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(title: &str, site: &Site, shots: &[Shot], events: &[Event], path: &Path) -> Result<(), ReportError> {
    let kept = chosen(shots, IMAGE);
    let Some(first) = kept.first() else { return Ok(()) };
    let scene = Scene::new(title, site, shots, events);
    let palette = palette();
    let mut known = HashMap::new();
    let mut images = Vec::new();
    for shot in &kept {
        let pixels = scene.drawn(shot).map_err(|cause| ReportError::Draw { path: path.to_owned(), cause })?;
        images.push(pixels.chunks_exact(3).map(|c| nearest([c[0], c[1], c[2]], &palette, &mut known)).collect());
    }
    let seeps = |shot: &Shot| shot.phase.starts_with("seepage");
    let shown = kept.iter().enumerate().map(|(k, shot)| match k {
        _ if k + 1 == kept.len() => SHOWN_MS[3],
        0 => SHOWN_MS[2],
        _ => SHOWN_MS[usize::from(!seeps(shot) || !seeps(first))],
    });
    let encoded = encode(scene.size, &palette, &images, &shown.collect::<Vec<_>>());
    let bytes = encoded.map_err(|e| unwritable(path, io::Error::other(e)))?;
    crate::report::save(path, bytes)
}

/// What all frames share.
struct Scene<'a> {
    title: &'a str,
    site: &'a Site,
    events: &'a [Event],
    /// Left, lower, right and upper end of the map, m.
    window: [f64; 4],
    /// Length of 1 m, px.
    unit: f64,
    /// Width and height, px.
    size: [usize; 2],
    /// Strain at the end of the scale.
    most: f64,
    /// Edge of a particle, m.
    edge: f64,
}

impl<'a> Scene<'a> {
    fn new(title: &'a str, site: &'a Site, shots: &[Shot], events: &'a [Event]) -> Self {
        let [left, low, right, high] = Window::of(site, shots).ends();
        let left = if site.tank_m > 0.0 { left.min(-TANK) } else { left };
        let unit = (WIDTH - EDGES[0] - EDGES[1]) / (right - left);
        let height = EDGES[2] + (high - low) * unit + BELOW;
        Self {
            title,
            site,
            events,
            window: [left, low, right, high],
            unit,
            size: [WIDTH as usize, height.ceil() as usize],
            most: STRAIN.range(shots).1,
            edge: map::edge(shots.first().map(|shot| &shot.frame)),
        }
    }

    fn across(&self, x: f64) -> f64 {
        EDGES[0] + (x - self.window[0]) * self.unit
    }

    fn down(&self, y: f64) -> f64 {
        EDGES[2] + (self.window[3] - y) * self.unit
    }

    /// The pixels of a frame, three bytes each.
    fn drawn(&self, shot: &Shot) -> Result<Vec<u8>, DrawError> {
        if !ready() {
            return Err(DrawError::Font);
        }
        let [width, height] = self.size;
        let mut pixels = vec![255; 3 * width * height];
        {
            let backend = BitMapBackend::with_buffer(&mut pixels, (width as u32, height as u32));
            let area = backend.into_drawing_area();
            let canvas = Canvas::new(&area, 1.0, BITMAP_LETTERS);
            self.tank(&canvas)?;
            self.axes(&canvas)?;
            self.words(&canvas, shot)?;
            self.legend(&canvas)?;
            area.present()?;
        }
        self.soil(shot, &mut pixels);
        {
            let backend = BitMapBackend::with_buffer(&mut pixels, (width as u32, height as u32));
            let area = backend.into_drawing_area();
            self.lines(&Canvas::new(&area, 1.0, BITMAP_LETTERS), shot)?;
            area.present()?;
        }
        Ok(pixels)
    }

    fn tank(&self, canvas: &Canvas<BitMapBackend>) -> Drawn {
        let (left, right, top, bottom) = (EDGES[0], self.across(0.0), self.down(self.site.tank_m), self.down(0.0));
        if self.site.tank_m <= 0.0 {
            return Ok(());
        }
        canvas.area(&[(left, top), (right, top), (right, bottom), (left, bottom)], POOL)?;
        canvas.line(&[(left, top), (right, top)], Look::new(BLUE, Marker::Dot).width(2.0))
    }

    fn axes(&self, canvas: &Canvas<BitMapBackend>) -> Drawn {
        let [left, low, right, high] = self.window;
        let grey = Look::new(GREY, Marker::Dot).width(1.0);
        for x in whole(left, right) {
            let spot = (self.across(f64::from(x)), self.down(low));
            canvas.line(&[spot, (spot.0, spot.1 + 4.0)], grey)?;
            let words = if x == 0 { "0 m".to_owned() } else { x.to_string() };
            canvas.text(&words, (spot.0, spot.1 + 12.0), 11.0, BLACK, MIDDLE, false)?;
        }
        for y in whole(low, high) {
            let spot = (self.across(left), self.down(f64::from(y)));
            canvas.line(&[(spot.0 - 4.0, spot.1), spot], grey)?;
            canvas.text(&y.to_string(), (spot.0 - 8.0, spot.1), 11.0, BLACK, RIGHT, false)?;
        }
        let corners = [(left, low), (right, low), (right, high), (left, high), (left, low)];
        canvas.line(&corners.map(|(x, y)| (self.across(x), self.down(y))), grey)
    }

    /// Title, time and what is going on.
    fn words(&self, canvas: &Canvas<BitMapBackend>, shot: &Shot) -> Drawn {
        canvas.text(self.title, (EDGES[0], 17.0), 17.0, BLACK, LEFT, false)?;
        canvas.text(&clock(shot.time_s), (WIDTH - EDGES[1], 17.0), 17.0, BLACK, RIGHT, false)?;
        let phase = shot.phase.split(", ").next().unwrap_or_default();
        let failure = self.events.iter().find(|e| e.name == "E2").map(|e| shot.time_s - e.time_s);
        let said = match failure.filter(|after| *after >= -0.05) {
            Some(after) => format!("{phase}, {after:.1} s after failure starts"),
            None if phase == "seepage" => "water seeps through the soil at rest".to_owned(),
            None if phase == "failing" => "the toe fails".to_owned(),
            None => phase.to_owned(),
        };
        canvas.text(&said, (EDGES[0], 42.0), 13.0, GREY, LEFT, false)
    }

    fn legend(&self, canvas: &Canvas<BitMapBackend>) -> Drawn {
        let top = self.down(self.window[1]) + 30.0;
        let mut left = EDGES[0];
        for (colour, words, wide) in [(SAND, "soil above the water level", 180.0), (WET, "below it", 76.0)] {
            canvas.area(&[(left, top), (left + 14.0, top), (left + 14.0, top + 14.0), (left, top + 14.0)], colour)?;
            canvas.text(words, (left + 19.0, top + 7.0), 11.5, BLACK, LEFT, false)?;
            left += wide;
        }
        canvas.text("deviator strain", (left + 88.0, top + 7.0), 11.5, BLACK, RIGHT, false)?;
        let bar = Rect { left: left + 96.0, top, right: WIDTH - EDGES[1] - 6.0, bottom: top + 14.0 };
        let step = (bar.right - bar.left) / SHADES as f64;
        for shade in 0..SHADES {
            let (a, b) = (bar.left + step * shade as f64, bar.left + step * (shade + 1) as f64);
            let middle = 0.5 * (bar.top + bar.bottom);
            for (wet, (top, bottom)) in [(false, (bar.top, middle)), (true, (middle, bar.bottom))] {
                canvas.area(&[(a, top), (b, top), (b, bottom), (a, bottom)], strained(wet, shade))?;
            }
        }
        for (place, words) in [(bar.left, "0".to_owned()), (bar.right, format!("{} and more", short(self.most, 2)))] {
            let hold = if place == bar.left { MIDDLE } else { RIGHT };
            canvas.text(&words, (place, bar.bottom + 10.0), 12.0, BLACK, hold, false)?;
        }
        Ok(())
    }

    /// Particles as squares, without smooth edges: they cost least.
    fn soil(&self, shot: &Shot, pixels: &mut [u8]) {
        // A little larger than at rest, for soil that has spread.
        let half = 0.55 * self.edge * self.unit + 0.3;
        let ([width, height], level) = (self.size, self.level(shot));
        let span = |middle: f64, most: usize| {
            let at = |v: f64| (v.round().max(0.0) as usize).min(most);
            at(middle - half)..at(middle + half)
        };
        for p in &shot.frame.solid {
            let wet = is_below(&level, p.x);
            let share = ((STRAIN.of)(p) / self.most).clamp(0.0, 1.0);
            let colour = strained(wet, (share * SHADES as f64).min(SHADES as f64 - 1.0) as usize);
            for y in span(self.down(p.x[1]), height) {
                for x in span(self.across(p.x[0]), width) {
                    let at = 3 * (y * width + x);
                    pixels[at..at + 3].copy_from_slice(&[colour.0, colour.1, colour.2]);
                }
            }
        }
    }

    /// The level of the water from the tank on, m.
    fn level(&self, shot: &Shot) -> Vec<(f64, f64)> {
        let level = map::level(&shot.frame);
        let tank = (self.site.tank_m > 0.0 && !level.is_empty()).then_some((0.0, self.site.tank_m));
        tank.into_iter().chain(level).collect()
    }

    /// The outline at the start and the level of the water.
    fn lines(&self, canvas: &Canvas<BitMapBackend>, shot: &Shot) -> Drawn {
        let outline: Vec<_> = self.site.closed().map(|(x, y)| (self.across(x), self.down(y))).collect();
        canvas.line(&outline, Look::new(BLACK, Marker::Dot).width(1.0).dash(Dash::Dashed))?;
        let level: Vec<_> = self.level(shot).iter().map(|(x, y)| (self.across(*x), self.down(*y))).collect();
        canvas.line(&level, Look::new(BLUE, Marker::Dot).width(2.0))
    }
}

/// Whole numbers within a range, every second if they are many.
fn whole(start: f64, end: f64) -> impl Iterator<Item = i32> {
    let step = if end - start > 40.0 {
        10
    } else if end - start > 20.0 {
        2
    } else {
        1
    };
    (start.ceil() as i32..=end.floor() as i32).filter(move |v| v % step == 0)
}

/// Whether a place is below a line.
fn is_below(line: &[(f64, f64)], [x, y]: [f64; 2]) -> bool {
    let pair = line.windows(2).find(|pair| pair[1].0 >= x);
    pair.is_some_and(|pair| {
        let ((a, left), (b, right)) = (pair[0], pair[1]);
        y <= left + ((x - a) / (b - a)).clamp(0.0, 1.0) * (right - left)
    })
}

/// The colour of soil at a shade of strain.
fn strained(wet: bool, shade: usize) -> RGBColor {
    let base = if wet { WET } else { SAND };
    let share = shade as f64 / (SHADES - 1) as f64;
    let (mut from, mut colour) = (0.0, base);
    for (to, next) in RAMPS[usize::from(wet)] {
        if share <= to {
            let part = (share - from) / (to - from);
            let mixed = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
            return RGBColor(mixed(colour.0, next.0), mixed(colour.1, next.1), mixed(colour.2, next.2));
        }
        (from, colour) = (to, next);
    }
    colour
}

/// All colours of the image: soil, water, lines and shades of grey for text.
fn palette() -> Vec<[u8; 3]> {
    let soil = [false, true].into_iter().flat_map(|wet| (0..SHADES).map(move |shade| strained(wet, shade)));
    let others = [WHITE, BLACK, GREY, POOL, BLUE];
    let colours = soil.chain(others).map(|c| [c.0, c.1, c.2]);
    let mut all: Vec<[u8; 3]> = colours.chain((1..24).map(|k| [(k * 255 / 24) as u8; 3])).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The place of the nearest colour of the palette.
fn nearest(colour: [u8; 3], palette: &[[u8; 3]], known: &mut HashMap<[u8; 3], u8>) -> u8 {
    *known.entry(colour).or_insert_with(|| {
        let off = |c: &[u8; 3]| -> i32 { (0..3).map(|k| (i32::from(c[k]) - i32::from(colour[k])).pow(2)).sum() };
        palette.iter().enumerate().min_by_key(|(_, c)| off(c)).map_or(0, |(k, _)| k as u8)
    })
}

/// The frames as an animated PNG that repeats for ever; `shown` is how long each stands, ms.
fn encode(
    [width, height]: [usize; 2],
    palette: &[[u8; 3]],
    images: &[Vec<u8>],
    shown: &[u16],
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    encoder.set_filter(png::FilterType::NoFilter);
    let mut colours = palette.concat();
    colours.resize(3 * 256, 0);
    encoder.set_palette(colours);
    let mut opaque = vec![255; 256];
    opaque[usize::from(SAME)] = 0;
    encoder.set_trns(opaque);
    encoder.set_animated(images.len() as u32, 0)?;
    let mut writer = encoder.write_header()?;
    for (k, image) in images.iter().enumerate() {
        let before = k.checked_sub(1).map(|before| &images[before]);
        let part = before.map_or([0, 0, width, height], |before| changed(before, image, width));
        let [left, top, wide, high] = part;
        writer.set_frame_delay(shown[k], 1000)?;
        if before.is_some() {
            // Of the frame before, the place would bound the size.
            writer.set_frame_position(0, 0)?;
            writer.set_frame_dimension(wide as u32, high as u32)?;
            writer.set_frame_position(left as u32, top as u32)?;
            writer.set_blend_op(png::BlendOp::Over)?;
        }
        let place = |x: usize, y: usize| (top + y) * width + left + x;
        let pixel = |at: usize| if before.is_some_and(|before| before[at] == image[at]) { SAME } else { image[at] };
        let data: Vec<u8> = (0..high).flat_map(|y| (0..wide).map(move |x| place(x, y))).map(pixel).collect();
        writer.write_image_data(&data)?;
    }
    writer.finish()?;
    Ok(bytes)
}

/// Left and upper end, width and height of what differs between two images; one pixel where nothing does.
fn changed(before: &[u8], now: &[u8], width: usize) -> [usize; 4] {
    let differ = || before.iter().zip(now).enumerate().filter(|(_, (a, b))| a != b).map(|(at, _)| at);
    let Some(first) = differ().next() else { return [0, 0, 1, 1] };
    let (mut left, mut right, mut last) = (width, 0, first);
    for at in differ() {
        (left, right, last) = (left.min(at % width), right.max(at % width), at);
    }
    let (top, bottom) = (first / width, last / width);
    [left, top, right - left + 1, bottom - top + 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::made_up;

    #[test]
    fn the_image_is_small_loops_and_stands_still_at_its_end() {
        let site = Site { outline: made_up::OUTLINE.to_vec(), tank_m: 2.3 };
        let event = Event { name: "E2".to_owned(), words: "failure starts".to_owned(), time_s: made_up::FAILURE_S };
        let folder = tempfile::tempdir().expect("a folder");
        let folder = std::env::var_os("MPM_KEEP_PICTURES").map_or(folder.path().to_owned(), Into::into);
        let path = folder.join("looping.png");
        write("A levee", &site, &made_up::shots(40, 60), &[event], &path).expect("an image");
        let bytes = std::fs::read(&path).expect("the image");
        assert!(bytes.len() < 600_000, "{}", bytes.len());
        let mut reader = png::Decoder::new(&bytes[..]).read_info().expect("a PNG");
        let control = reader.info().animation_control.expect("animated");
        assert!(control.num_plays == 0 && (50..=60).contains(&control.num_frames), "{control:?}");
        assert_eq!(reader.info().width, 720);
        let mut pixels = vec![0; 4 * 720 * 720];
        let mut last = 0;
        for _ in 0..control.num_frames {
            reader.next_frame(&mut pixels).expect("a frame");
            last = reader.info().frame_control.expect("a frame of an animation").delay_num;
        }
        assert_eq!(last, SHOWN_MS[3]);
    }

    #[test]
    fn only_what_changes_is_held() {
        let before = vec![0; 30];
        let mut now = before.clone();
        assert_eq!(changed(&before, &now, 6), [0, 0, 1, 1]);
        (now[8], now[21]) = (1, 2);
        assert_eq!(changed(&before, &now, 6), [2, 1, 2, 3]);
        assert!(palette().len() < usize::from(SAME));
    }
}

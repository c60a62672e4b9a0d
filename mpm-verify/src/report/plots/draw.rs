//! Draws a [`Figure`] on any backend: title, rows of panels with frames and ticks, legend below, where it hides nothing.

use plotters::prelude::{DrawingBackend, RGBColor};

use super::axis::Axis;
use super::canvas::{Canvas, Drawn, LEFT, MIDDLE, RIGHT, Rect, Spot, text_width};
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::legend::{self, Entry};
use super::look::{BLACK, Dash, GREY, Look, Marker, PALE};

/// Width of every picture, px.
pub const WIDTH: f64 = 900.0;
/// Size of ordinary text, px.
pub const TEXT: f64 = 12.5;
const TITLE: f64 = 15.0;
/// Size of notes at points, px.
const NOTE: f64 = 11.5;
/// Room above the panels for the title of the picture and those of the panels.
const ABOVE: f64 = 58.0;
/// Room below the panels for ticks and the name of the axis.
const BELOW: f64 = 46.0;
/// The same where the axis has no name.
const TICKS: f64 = 28.0;
/// The same where its ticks have no texts.
const QUIET: f64 = 9.0;
/// Further room for the titles of a row that is not the first.
const TITLED: f64 = 27.0;
const MARGIN: f64 = 12.0;

/// Height of a picture, px.
pub fn height(figure: &Figure) -> f64 {
    let rows = rows(figure);
    let end = rows.last().map_or(ABOVE + figure.height, Row::bottom);
    end + BELOW + legend::height(&legend::entries(figure)) + MARGIN
}

/// Panels side by side.
struct Row<'a> {
    /// Upper edge of the frames, px.
    top: f64,
    /// Height of the highest frame, px.
    height: f64,
    panels: Vec<&'a Panel>,
}

impl Row<'_> {
    fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// The rows, each with room for what stands below the one above it and for its own titles.
fn rows(figure: &Figure) -> Vec<Row<'_>> {
    let mut rows: Vec<Row> = Vec::new();
    let count = figure.panels.iter().map(|p| p.row + 1).max().unwrap_or(0);
    for number in 0..count {
        let panels: Vec<&Panel> = figure.panels.iter().filter(|p| p.row == number).collect();
        let height = panels.iter().map(|p| p.height.unwrap_or(figure.height)).fold(0.0, f64::max);
        let top = rows.last().map_or(ABOVE, |above| {
            let below = match above.panels.iter().filter(|p| !p.blank).collect::<Vec<_>>() {
                all if all.iter().any(|p| !p.x.label.is_empty()) => BELOW,
                all if all.iter().any(|p| !p.x.quiet) => TICKS,
                _ => QUIET,
            };
            let titled = panels.iter().any(|p| !p.title.is_empty());
            above.bottom() + below + if titled { TITLED } else { 0.0 }
        });
        rows.push(Row { top, height, panels });
    }
    rows
}

/// Draws everything.
///
/// # Errors
/// What the backend says.
pub fn figure<DB: DrawingBackend>(figure: &Figure, canvas: &Canvas<DB>) -> Drawn {
    canvas.text(&figure.title, (WIDTH / 2.0, 17.0), TITLE, BLACK, MIDDLE, false)?;
    let rows = rows(figure);
    // Frames below each other begin at the same place: room is made for the widest tick of the column.
    let mut widest: Vec<f64> = Vec::new();
    for (column, panel) in rows.iter().flat_map(|row| row.panels.iter().enumerate()) {
        let own = ticks_width(&(*panel).clone().fitted());
        match widest.get_mut(column) {
            Some(known) => *known = known.max(own),
            None => widest.push(own),
        }
    }
    for row in &rows {
        let shares: f64 = row.panels.iter().map(|p| p.share).sum();
        let gap = 14.0;
        let whole = WIDTH - 2.0 * MARGIN - gap * (row.panels.len() as f64 - 1.0);
        let mut left = MARGIN;
        for (panel, ticks) in row.panels.iter().zip(&widest) {
            let width = whole * panel.share / shares;
            let bottom = row.top + panel.height.unwrap_or(figure.height);
            let room = Rect { left, top: row.top, right: left + width, bottom };
            if !panel.blank {
                let place = figure.panels.iter().position(|p| std::ptr::eq(p, *panel)).unwrap_or_default();
                draw_panel(canvas, &(*panel).clone().fitted(), (room, *ticks), place)?;
            }
            left += width + gap;
        }
    }
    let entries: Vec<Entry> = legend::entries(figure);
    legend::draw(canvas, &entries, rows.last().map_or(ABOVE + figure.height, Row::bottom) + BELOW)
}

/// Width of the widest text at the vertical axis, px.
fn ticks_width(panel: &Panel) -> f64 {
    panel.y.ticks().iter().map(|(_, t)| text_width(t, TEXT)).fold(0.0, f64::max)
}

/// One panel with what stands around it. `room` is as wide as everything and as high as the frame; `widest` is the
/// width of the texts at the vertical axis; `number` is its place in the figure.
fn draw_panel<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    panel: &Panel,
    (room, widest): (Rect, f64),
    number: usize,
) -> Drawn {
    let mut frame = Rect { left: room.left + widest + 34.0, right: room.right - 10.0, ..room };
    if panel.equal {
        frame = equal_units(panel, frame);
    }
    let middle = (0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom));
    canvas.text(&panel.title, (middle.0, room.top - 14.0), TEXT, BLACK, MIDDLE, false)?;
    canvas.text(&panel.x.title(), (middle.0, frame.bottom + 36.0), TEXT, BLACK, MIDDLE, false)?;
    canvas.text(&panel.y.title(), (frame.left - widest - 24.0, middle.1), TEXT, BLACK, MIDDLE, true)?;
    canvas.mark_panel(number, frame)?;
    let view = View { panel, frame };
    view.grid(canvas)?;
    // An area of the legend would hide what is drawn before it; others are the paper under a text, which is to hide it.
    let is_area = |series: &&Series| series.mark == Mark::Area && series.in_legend;
    let (areas, others): (Vec<&Series>, Vec<&Series>) = panel.series.iter().partition(is_area);
    for series in areas.into_iter().chain(others) {
        canvas.mark(&format!("series {}", series.label))?;
        view.series(canvas, series)?;
        canvas.mark("end")?;
    }
    view.notes(canvas)?;
    view.edge(canvas)?;
    if panel.is_empty() {
        canvas.text("no data in this study", middle, TEXT, GREY, MIDDLE, false)?;
    }
    Ok(())
}

/// The largest frame within another in which one unit is equally long on both axes.
fn equal_units(panel: &Panel, frame: Rect) -> Rect {
    let length = |axis: &Axis| axis.range.map_or(1.0, |(start, end)| (end - start).abs());
    let (width, height) = (frame.right - frame.left, frame.bottom - frame.top);
    let unit = (width / length(&panel.x)).min(height / length(&panel.y));
    let spare = width - unit * length(&panel.x);
    let low = frame.top + unit * length(&panel.y);
    Rect { left: frame.left + 0.5 * spare, right: frame.right - 0.5 * spare, bottom: low, ..frame }
}

/// A panel in its frame.
struct View<'a> {
    panel: &'a Panel,
    frame: Rect,
}

impl View<'_> {
    fn across(&self, x: f64) -> f64 {
        self.frame.left + self.panel.x.place(x) * (self.frame.right - self.frame.left)
    }

    fn down(&self, y: f64) -> f64 {
        self.frame.bottom - self.panel.y.place(y) * (self.frame.bottom - self.frame.top)
    }

    /// Where a point is; `None` where an axis has no place for it.
    fn spot(&self, p: &Point) -> Option<Spot> {
        let has_place = self.panel.x.takes(p.x) && self.panel.y.takes(p.y);
        has_place.then(|| (self.across(p.x), self.down(p.y)))
    }

    /// Ticks with their texts, and grid lines at those that have one.
    fn grid<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let frame = self.frame;
        let (fine, tick) = (thin(PALE, 0.8), thin(GREY, 1.0));
        for (value, text) in self.panel.x.ticks() {
            let x = self.across(value);
            if !text.is_empty() && !self.panel.equal {
                canvas.line(&[(x, frame.top), (x, frame.bottom)], fine)?;
            }
            if !text.is_empty() && !self.panel.x.quiet {
                canvas.text(&text, (x, frame.bottom + 14.0), TEXT, BLACK, MIDDLE, false)?;
            }
            let length = if text.is_empty() { 3.0 } else { 6.0 };
            canvas.line(&[(x, frame.bottom), (x, frame.bottom + length)], tick)?;
        }
        for (value, text) in self.panel.y.ticks() {
            let y = self.down(value);
            if !text.is_empty() && !self.panel.equal {
                canvas.line(&[(frame.left, y), (frame.right, y)], fine)?;
            }
            if !text.is_empty() {
                canvas.text(&text, (frame.left - 9.0, y), TEXT, BLACK, RIGHT, false)?;
            }
            let length = if text.is_empty() { 3.0 } else { 6.0 };
            canvas.line(&[(frame.left - length, y), (frame.left, y)], tick)?;
        }
        Ok(())
    }

    fn edge<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let Rect { left, top, right, bottom } = self.frame;
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        canvas.line(&corners, thin(GREY, 1.0))
    }

    fn series<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, series: &Series) -> Drawn {
        let look = series.look;
        if matches!(series.mark, Mark::Line | Mark::LinePoints) {
            self.polyline(canvas, series)?;
        }
        if series.mark == Mark::Area {
            let corners: Vec<Spot> = series.points.iter().filter_map(|p| self.spot(p)).collect();
            canvas.area(&corners, look.colour)?;
        }
        if series.mark == Mark::Tiles {
            let corners = |tile: &[Point]| tile.iter().filter_map(|p| self.spot(p)).collect();
            return canvas.tiles(&series.points.chunks(4).map(corners).collect::<Vec<_>>(), look.colour);
        }
        if canvas.takes_marks() && is_cloud(series) {
            let spots: Vec<Spot> = series.points.iter().filter_map(|p| self.spot(p)).collect();
            return canvas.mark_cloud(&spots, look);
        }
        let mut last = None;
        for point in &series.points {
            let Some(spot) = self.spot(point) else { continue };
            // A marker on the very same one would not be seen, and makes a file larger.
            let same = last.replace((canvas.at(spot), point.open)) == last;
            match series.mark {
                Mark::Points | Mark::LinePoints if same => {}
                Mark::Points | Mark::LinePoints => canvas.marker(spot, look, point.open)?,
                Mark::Bars => self.bar(canvas, point, spot, look)?,
                Mark::Arrows => arrow(canvas, (spot.0, self.down(point.from)), spot, look)?,
                Mark::Range => range(canvas, spot, self.down(point.from), look)?,
                Mark::Line | Mark::Area | Mark::Tiles | Mark::Text | Mark::Middle => {}
            }
        }
        Ok(())
    }

    /// A line that breaks off where a point has no place, and at the frame.
    fn polyline<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, series: &Series) -> Drawn {
        let mut run: Vec<Spot> = Vec::new();
        let spots: Vec<Option<Spot>> = series.points.iter().map(|p| self.spot(p)).collect();
        for pair in spots.windows(2) {
            let part = match (pair[0], pair[1]) {
                (Some(a), Some(b)) => self.frame.clip(a, b),
                _ => None,
            };
            let Some((a, b)) = part else {
                canvas.line(&std::mem::take(&mut run), series.look)?;
                continue;
            };
            // Where a line turns back, a mitred corner would reach far beyond it.
            let turns_back = run.len() > 1 && is_sharp(run[run.len() - 2], a, b);
            if run.last() != Some(&a) || turns_back {
                canvas.line(&std::mem::take(&mut run), series.look)?;
                run.push(a);
            }
            run.push(b);
        }
        canvas.line(&run, series.look)
    }

    fn bar<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, point: &Point, spot: Spot, look: Look) -> Drawn {
        let half = 0.5 * (self.across(point.x + 0.66) - spot.0);
        let other = self.down(point.from);
        let (top, bottom) = (spot.1.min(other), spot.1.max(other));
        if bottom - top < 0.3 {
            return Ok(());
        }
        canvas.bar(Rect { left: spot.0 - half, top, right: spot.0 + half, bottom }, look)
    }

    /// Notes, each at its place if it is all there is, otherwise beside its point where it hides least.
    fn notes<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let mut taken = self.segments();
        for series in self.panel.series.iter().filter(|s| s.points.iter().any(|p| !p.note.is_empty())) {
            canvas.mark(&format!("series {}", series.label))?;
            for point in series.points.iter().filter(|p| !p.note.is_empty()) {
                let Some(spot) = self.spot(point) else { continue };
                if matches!(series.mark, Mark::Text | Mark::Middle) {
                    let hold = if series.mark == Mark::Text { LEFT } else { MIDDLE };
                    canvas.text(&point.note, spot, TEXT, series.look.colour, hold, false)?;
                    continue;
                }
                let room = self.free_room(spot, text_width(&point.note, NOTE), &taken);
                let middle = (0.5 * (room.left + room.right), 0.5 * (room.top + room.bottom));
                canvas.text(&point.note, middle, NOTE, series.look.colour, MIDDLE, false)?;
                taken.push(((room.left, middle.1), (room.right, middle.1)));
            }
            canvas.mark("end")?;
        }
        Ok(())
    }

    /// All lines of the panel and a stroke through each marker, px.
    fn segments(&self) -> Vec<(Spot, Spot)> {
        let mut segments = Vec::new();
        // A cloud of small dots may be written over.
        for series in self.panel.series.iter().filter(|s| s.mark != Mark::Points || s.look.radius > 1.5) {
            let spots: Vec<Option<Spot>> = series.points.iter().map(|p| self.spot(p)).collect();
            if matches!(series.mark, Mark::Line | Mark::LinePoints) {
                segments.extend(spots.windows(2).filter_map(|pair| Some((pair[0]?, pair[1]?))));
            }
            let r = series.look.radius;
            segments.extend(spots.iter().flatten().map(|s| ((s.0, s.1 - r), (s.0, s.1 + r))));
        }
        segments
    }

    /// Room for a note above, below, right or left of a spot: the one that the fewest lines cross.
    fn free_room(&self, spot: Spot, width: f64, taken: &[(Spot, Spot)]) -> Rect {
        let (half, high) = (0.5 * width + 2.0, 0.6 * NOTE + 1.0);
        let room = |x: f64, y: f64| Rect { left: x - half, top: y - high, right: x + half, bottom: y + high };
        let sides = [(0.0, -16.0), (0.0, 16.0), (half + 8.0, 0.0), (-half - 8.0, 0.0)];
        let rooms = sides.map(|(dx, dy)| room(spot.0 + dx, spot.1 + dy));
        let frame = self.frame;
        let crossed = |r: &Rect| {
            let outside = r.left < frame.left || r.right > frame.right || r.top < frame.top || r.bottom > frame.bottom;
            taken.iter().filter(|(a, b)| r.clip(*a, *b).is_some()).count() + if outside { 100 } else { 0 }
        };
        rooms.into_iter().min_by_key(crossed).unwrap_or(frame)
    }
}

/// Fewer markers than these are drawn one by one.
const CLOUD: usize = 60;

/// Whether a series is a cloud of filled markers.
fn is_cloud(series: &Series) -> bool {
    let simple = matches!(series.look.marker, Marker::Dot | Marker::Circle | Marker::Square | Marker::Box);
    series.mark == Mark::Points && series.points.len() >= CLOUD && simple && !series.points.iter().any(|p| p.open)
}

/// Whether the way from `a` over `b` to `c` turns by more than a right angle.
fn is_sharp(a: Spot, b: Spot, c: Spot) -> bool {
    (b.0 - a.0) * (c.0 - b.0) + (b.1 - a.1) * (c.1 - b.1) < 0.0
}

/// A thin unbroken line.
fn thin(colour: RGBColor, width: f64) -> Look {
    Look::new(colour, Marker::Dot).width(width).dash(Dash::Solid)
}

/// An upright bar with ends.
pub(super) fn range<DB: DrawingBackend>(canvas: &Canvas<DB>, spot: Spot, other: f64, look: Look) -> Drawn {
    let end = |y: f64| [(spot.0 - look.radius, y), (spot.0 + look.radius, y)];
    canvas.line(&[spot, (spot.0, other)], look)?;
    canvas.line(&end(spot.1), look)?;
    canvas.line(&end(other), look)
}

/// An arrow from one spot down to another.
fn arrow<DB: DrawingBackend>(canvas: &Canvas<DB>, from: Spot, to: Spot, look: Look) -> Drawn {
    let head = Look { marker: Marker::Down, ..look };
    canvas.line(&[from, (to.0, to.1 - look.radius)], look)?;
    canvas.marker((to.0, to.1 - 1.15 * look.radius), head, false)
}

//! A forest plot of all claims: one row per comparison with its interval, the expected range and the verdict.
//! Claims with the same unit share an axis.

use super::View;
use crate::report::claim::{Case, Judged, Ruling};
use crate::report::estimate::Estimate;
use crate::report::figure::Figure;
use crate::report::plot::axis::written;
use crate::report::plot::drawing::text_width;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::suite::judged;
use crate::report::wording::{arm_in_words, shortened};

/// The figure's name.
pub const ID: &str = "claims";
/// Heights of a row, above a panel and below it, in pixels.
const ROW: f64 = 22.0;
const HEAD: f64 = 10.0;
const BELOW: f64 = 44.0;
/// Width of the panels.
const WIDTH: f64 = 400.0;
/// More comparisons of a claim than this share a row.
const APART: usize = 6;
/// Height of the marks of the comparisons that share a row with the worst of them, in pixels.
const SPREAD: f64 = 14.0;

/// A comparison of a claim, or the worst of many with the others.
struct Row<'a> {
    claim: &'a Judged,
    case: &'a Case,
    others: Vec<&'a Case>,
    among: Among,
}

/// The position of a comparison among those of its claim in a panel.
#[derive(Clone, Copy, PartialEq)]
enum Among {
    /// The only one.
    Alone,
    /// The first of several; the claim's name is on a separate line above it.
    First,
    /// A later one.
    Later,
    /// The worst of many, which share its row; the claim's name is on a separate line above it.
    Worst,
}

/// The figure, if at least one claim was measured.
pub fn figure(view: &View) -> Option<Figure> {
    let claims = judged(view.input);
    let panels = panels(&claims);
    if panels.is_empty() {
        return None;
    }
    let rows = || panels.iter().flat_map(|(_, rows)| rows);
    let widths = rows().map(|row| width_of(&row.label(), false).max(width_of(&row.heading(), true)));
    let left = 18.0 + widths.fold(0.0, f64::max);
    let beside = |row: &Row| match row.has_heading() {
        true => width_of(&row.words(), row.is_decided()).max(width_of(&row.verdict(), false)),
        false => width_of(&row.words(), row.is_decided()),
    };
    let right = 24.0 + rows().map(beside).fold(0.0, f64::max);
    let height: f64 = panels.iter().map(|(_, rows)| HEAD + lines(rows) + BELOW).sum();
    let mut drawing = Drawing::new(left + WIDTH + right, height + 8.0, "Claims");
    let mut top = 8.0;
    for (label, rows) in &panels {
        let area = Area { left, top: top + HEAD, width: WIDTH, height: lines(rows) };
        panel(&mut drawing, area, label, rows);
        top = area.bottom() + BELOW;
    }
    let cases = || rows().flat_map(Row::cases);
    let mut sources: Vec<_> = cases().flat_map(|case| case.sources.clone()).collect();
    sources.sort();
    sources.dedup();
    Some(Figure {
        id: ID.to_string(),
        title: "Claims".to_string(),
        caption: caption(&claims, cases().count(), rows().any(|row| row.among == Among::Worst)),
        drawing,
        sources,
    })
}

fn caption(claims: &[Judged], cases: usize, shares_rows: bool) -> String {
    let over = match claims.iter().any(|claim| !claim.alternatives.is_empty()) {
        true => {
            " Of a claim about some or no point of an axis a row says whether the expectation holds in that \
             comparison."
        }
        false => "",
    };
    let has_number =
        claims.iter().any(|claim| claim.paper.as_ref().is_some_and(|paper| paper.number.is_some()));
    let paper = if has_number { " Diamonds: what the paper reports." } else { "" };
    let shared = match shares_rows {
        true => format!(
            " A claim with more than {APART} comparisons has one row: the labelled one is the worst, closest \
             to or farthest beyond what the claim expects, and the thin marks are the others."
        ),
        false => String::new(),
    };
    format!(
        "Estimates with their intervals; shaded: what the claim expects.{paper} Filled dots pass, crosses \
         fail, rings are not established, each comparison alone; the verdict on a claim is corrected for the \
         number of claims.{shared} {cases} comparisons of {} claims; n counts runs or episodes.{over}",
        claims.len()
    )
}

/// The rows by axis label, in the order of the claims; claims without a comparison have no row.
fn panels(claims: &[Judged]) -> Vec<(String, Vec<Row<'_>>)> {
    let mut panels: Vec<(String, Vec<Row<'_>>)> = Vec::new();
    for claim in claims {
        let mut by_label: Vec<(String, Vec<&Case>)> = Vec::new();
        for case in &claim.cases {
            let label = axis_label(claim, case);
            match by_label.iter_mut().find(|(known, _)| *known == label) {
                Some((_, cases)) => cases.push(case),
                None => by_label.push((label, vec![case])),
            }
        }
        for (label, cases) in by_label {
            let rows = rows(claim, cases);
            match panels.iter_mut().find(|(known, _)| *known == label) {
                Some((_, known)) => known.extend(rows),
                None => panels.push((label, rows)),
            }
        }
    }
    panels
}

/// The rows of a claim's comparisons: many share that of the worst.
fn rows<'a>(claim: &'a Judged, mut cases: Vec<&'a Case>) -> Vec<Row<'a>> {
    let row = |case, among| Row { claim, case, others: Vec::new(), among };
    if cases.len() > APART && claim.alternatives.is_empty() {
        let by_margin = |a: &usize, b: &usize| margin(claim, cases[*a]).total_cmp(&margin(claim, cases[*b]));
        let worst = (0..cases.len()).min_by(by_margin).unwrap_or(0);
        let case = cases.remove(worst);
        return vec![Row { others: cases, ..row(case, Among::Worst) }];
    }
    let among = |place| match (cases.len(), place) {
        (1, _) => Among::Alone,
        (_, 0) => Among::First,
        _ => Among::Later,
    };
    cases.iter().enumerate().map(|(place, case)| row(*case, among(place))).collect()
}

/// How far a comparison's interval is within what the claim expects; negative beyond it, and least where
/// nothing was measured.
fn margin(claim: &Judged, case: &Case) -> f64 {
    let Estimate { value, low, high, .. } = case.estimate;
    let [above, below] = [(low.or(value), claim.bounds[0], 1.0), (high.or(value), claim.bounds[1], -1.0)]
        .map(|(end, bound, sign)| {
            bound.map(|bound| end.map_or(f64::NEG_INFINITY, |end| sign * (end - bound)))
        });
    [above, below].into_iter().flatten().fold(f64::INFINITY, f64::min)
}

/// Height of all rows, including the claim names above them.
fn lines(rows: &[Row]) -> f64 {
    rows.iter().map(Row::height).sum()
}

/// `difference (points)`, `survival (%)`, `probability of improvement (%)`.
fn axis_label(claim: &Judged, case: &Case) -> String {
    let own = claim.metric.split(' ').next().unwrap_or_default();
    let metric = own.rsplit('.').next().unwrap_or_default();
    let what = crate::kinds::metric::find(metric).map_or(metric, |metric| metric.label);
    let unit = |text: &str| if text.is_empty() { String::new() } else { format!(" ({text})") };
    if claim.factor != 1.0 {
        return format!("{what}, a - {} b{}", claim.factor, unit(case.estimate.unit.as_str()));
    }
    match (claim.test.as_str(), case.sides.len(), case.estimate.unit.as_str()) {
        ("probability_of_improvement", ..) => "probability of improvement (%)".to_owned(),
        (_, 2, "%") => "difference of shares (points)".to_owned(),
        (_, 2, own) => format!("difference of the {what}{}", unit(own)),
        (_, _, "%") => "share (%)".to_owned(),
        (_, _, own) => format!("{what}{}", unit(own)),
    }
}

impl Row<'_> {
    /// Its comparisons.
    fn cases(&self) -> impl Iterator<Item = &Case> {
        [self.case].into_iter().chain(self.others.iter().copied())
    }

    fn label(&self) -> String {
        let case = arm_in_words(&self.case.label);
        let text = match (self.among, case.as_str()) {
            (Among::Worst, label) => format!("worst of {}: {label}", 1 + self.others.len()),
            (Among::Alone, "") => self.claim.id.clone(),
            (Among::Alone, label) => format!("{}, {label}", self.claim.id),
            (Among::First | Among::Later, label) => label.to_owned(),
        };
        shortened(&text, 44)
    }

    /// Whether the claim's name is above it.
    fn has_heading(&self) -> bool {
        matches!(self.among, Among::First | Among::Worst)
    }

    /// The text above it: the claim's name for the first of several, or for all of them.
    fn heading(&self) -> String {
        if self.has_heading() { shortened(&self.claim.id, 44) } else { String::new() }
    }

    /// The verdict on the claim, beside its name.
    fn verdict(&self) -> String {
        format!("the claim: {}", self.claim.verdict.word())
    }

    /// Height, including its heading.
    fn height(&self) -> f64 {
        if self.has_heading() { 2.0 * ROW } else { ROW }
    }

    fn scale(&self) -> f64 {
        if self.case.estimate.unit == "%" { 100.0 } else { 1.0 }
    }

    /// A value in the unit of the axis; `None` if missing or not finite.
    fn place(&self, value: Option<f64>) -> Option<f64> {
        value.filter(|value| value.is_finite()).map(|value| self.scale() * value)
    }

    fn ruling(&self) -> Ruling {
        self.claim.ruling_of(self.case)
    }

    /// Whether it passes or fails, which is printed in bold.
    fn is_decided(&self) -> bool {
        matches!(self.ruling(), Ruling::Pass | Ruling::Fail)
    }

    /// The verdict; one of several comparisons has its own.
    fn word(&self) -> &'static str {
        self.claim.word_of(self.case)
    }

    /// `PASS: 31 [12, 48], n = 5 and 5`.
    fn words(&self) -> String {
        let digits = |value: f64| written(value, self.case.estimate.digits);
        let number = match self.place(self.case.estimate.value) {
            Some(value) => digits(value),
            None => "\u{2013}".to_owned(),
        };
        let ends = [self.place(self.case.estimate.low), self.place(self.case.estimate.high)];
        let interval = match ends {
            [Some(low), Some(high)] => format!(" [{}, {}]", digits(low), digits(high)),
            _ => String::new(),
        };
        let n: Vec<String> = self.case.n.iter().map(usize::to_string).collect();
        format!("{}: {number}{interval}, n = {}", self.word(), n.join(" and "))
    }

    /// Positions of the expected range's ends on the panel; `None` for an open end.
    fn bounds(&self, panel: &Panel) -> [Option<f64>; 2] {
        self.claim.bounds.map(|bound| self.place(bound).map(|value| panel.place(value, 0.0)[0]))
    }

    /// What the paper reports, on the axis; `None` if the claim does not say it as a number.
    fn paper(&self) -> Option<f64> {
        let number = self.claim.paper.as_ref()?.number.as_ref()?;
        self.place(Some(number.si))
    }

    /// The values that the axis must include.
    fn reach(&self) -> impl Iterator<Item = f64> {
        let [low, high] = self.claim.bounds;
        let paper = self.claim.paper.as_ref().and_then(|paper| Some(paper.number.as_ref()?.si));
        let ends = |case: &Case| [case.estimate.value, case.estimate.low, case.estimate.high];
        let all = self.cases().flat_map(ends).chain([low, high, paper]);
        all.filter_map(|value| self.place(value))
    }
}

fn panel(drawing: &mut Drawing, area: Area, label: &str, rows: &[Row]) {
    let reach = Axis::fit("", rows.iter().flat_map(Row::reach), 6).range;
    let margin = 0.06 * (reach[1] - reach[0]);
    let panel = Panel {
        area,
        x: Axis::over(label, [reach[0] - margin, reach[1] + margin], 6),
        y: Axis { label: String::new(), range: [0.0, lines(rows)], ticks: Vec::new() },
    };
    let tops = rows.iter().scan(area.top, |below, row| {
        *below += row.height();
        Some((*below - ROW, row))
    });
    tops.clone().for_each(|(top, row)| shade(drawing, &panel, row, top));
    panel.frame(drawing, "");
    for (value, _) in &panel.x.ticks {
        let x = panel.place(*value, 0.0)[0];
        drawing.line(&[[x, area.top], [x, area.bottom()]], Stroke::solid(Ink::Grid, 1.0));
    }
    for (top, row) in tops {
        let y = top + 0.5 * ROW;
        if row.has_heading() {
            let y = y - ROW + 4.0;
            drawing.text([area.left - 10.0, y], row.heading(), Ink::Text, Anchor::End).bold = true;
            drawing.text([area.right() + 12.0, y], row.verdict(), Ink::Muted, Anchor::Start);
        }
        for bound in row.bounds(&panel).into_iter().flatten() {
            drawing
                .line(&[[bound, top + 1.0], [bound, top + ROW - 1.0]], Stroke::dashed(Ink::Reference, 1.6));
        }
        draw(drawing, &panel, row, y);
        drawing.text([area.left - 10.0, y + 4.0], row.label(), Ink::Text, Anchor::End);
        let words = drawing.text([area.right() + 12.0, y + 4.0], row.words(), Ink::Text, Anchor::Start);
        words.bold = row.is_decided();
    }
}

/// Estimated width of a text in pixels; bold is 10 % wider.
fn width_of(text: &str, bold: bool) -> f64 {
    if bold { 1.1 * text_width(text, 12.0) } else { text_width(text, 12.0) }
}

/// Shades the expected range.
fn shade(drawing: &mut Drawing, panel: &Panel, row: &Row, top: f64) {
    let [low, high] = row.bounds(panel);
    if low.is_none() && high.is_none() {
        return;
    }
    let (left, right) = (low.unwrap_or(panel.area.left), high.unwrap_or(panel.area.right()));
    drawing.rectangle([left, top + 2.0], [right, top + ROW - 2.0], Ink::Shade, 1.0);
}

fn draw(drawing: &mut Drawing, panel: &Panel, row: &Row, y: f64) {
    let across = |value: f64| panel.place(value, 0.0)[0];
    let step = SPREAD / row.others.len().max(1) as f64;
    for (place, case) in row.others.iter().enumerate() {
        let y = y + step * (place as f64 + 0.5) - 0.5 * SPREAD;
        let [value, low, high] =
            [case.estimate.value, case.estimate.low, case.estimate.high].map(|value| row.place(value));
        if let [Some(low), Some(high)] = [low, high] {
            let ends = [[across(low), y], [across(high), y]];
            drawing.line(&ends, Stroke::solid(Ink::Muted, 0.8).faint(0.6));
        }
        if let Some(value) = value {
            drawing.dot([across(value), y], 1.3, Ink::Muted, 0.8);
        }
    }
    let ink = match row.ruling() {
        Ruling::Pass => Ink::Arm(0),
        Ruling::Fail => Ink::Arm(1),
        Ruling::NotEstablished | Ruling::NotMeaningful => Ink::Muted,
    };
    if let [Some(low), Some(high)] = [row.place(row.case.estimate.low), row.place(row.case.estimate.high)] {
        let (low, high) = (across(low), across(high));
        drawing.line(&[[low, y], [high, y]], Stroke::solid(ink, 2.0));
        for end in [low, high] {
            drawing.line(&[[end, y - 4.0], [end, y + 4.0]], Stroke::solid(ink, 2.0));
        }
    }
    if let Some(paper) = row.paper() {
        diamond(drawing, [across(paper), y]);
    }
    let Some(value) = row.place(row.case.estimate.value) else { return };
    let x = across(value);
    match row.ruling() {
        Ruling::Pass => drawing.dot([x, y], 4.5, ink, 1.0),
        Ruling::Fail => {
            for slope in [-1.0, 1.0] {
                drawing
                    .line(&[[x - 4.5, y - 4.5 * slope], [x + 4.5, y + 4.5 * slope]], Stroke::solid(ink, 2.4));
            }
        }
        Ruling::NotEstablished | Ruling::NotMeaningful => drawing.ring([x, y], 4.0, Stroke::solid(ink, 2.0)),
    }
}

/// The mark of the paper's value.
fn diamond(drawing: &mut Drawing, [x, y]: [f64; 2]) {
    const SIZE: f64 = 6.0;
    let corners = [[x - SIZE, y], [x, y - SIZE], [x + SIZE, y], [x, y + SIZE], [x - SIZE, y]];
    drawing.line(&corners, Stroke::solid(Ink::Reference, 2.0));
}

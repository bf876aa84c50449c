//! Enclosures side by side, which do not see each other.

use super::Enclosure;
use azulejo_factors::FaceId;
use azulejo_factors::form_factors::ExchangeAreas;

impl Enclosure {
    /// The rows of this enclosure, followed by those of another of the same materials, without exchange between
    /// them. Polygons are those of the first, and light and patches from outside are left out, as nobody needs them of several.
    #[must_use]
    pub fn beside(mut self, other: Enclosure) -> Enclosure {
        let (rows, objects) = (self.len() as u32, self.rows.objects.len() as u32);
        self.outside = None;
        self.sky = None;
        let (a, b) = (&mut self.factors, other.factors);
        append(&mut a.exchange, &b.exchange, rows);
        let orders = a.orders.iter_mut().zip(&b.orders);
        orders.for_each(|(a, b)| append(a, b, rows));
        a.areas.extend(b.areas);
        let moved = |face: FaceId| FaceId {
            object: face.object + objects,
            ..face
        };
        a.faces.extend(b.faces.into_iter().map(moved));
        a.materials.extend(b.materials);
        a.is_back.extend(b.is_back);
        a.rest.extend(b.rest);
        a.ends.extend(b.ends);
        a.row_errors.extend(b.row_errors);
        a.unseen.extend(b.unseen);
        if a.unseen.len() != a.areas.len() {
            a.unseen.clear();
        }
        a.is_closed &= b.is_closed;
        if let (Some(a), Some(b)) = (&mut a.closed, b.closed) {
            a.most = a.most.max(b.most);
            a.deficit = a.deficit.max(b.deficit);
            a.mean = a.mean.max(b.mean);
            a.total = a.total.max(b.total);
        }
        a.rays += b.rays;
        let (a, b) = (&mut self.rows, other.rows);
        a.names.extend(b.names);
        a.objects.extend(b.objects);
        a.zones.extend(b.zones);
        a.diffuse.extend(b.diffuse);
        self
    }
}

fn append(to: &mut ExchangeAreas, from: &ExchangeAreas, columns: u32) {
    for row in 0..from.len() {
        let entries = from.upper(row).iter().copied();
        to.push_row(entries.map(|mut entry| {
            entry.column += columns;
            entry
        }));
    }
}

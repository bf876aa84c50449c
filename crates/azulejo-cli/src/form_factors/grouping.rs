//! Rows combined as requested.

use super::args::FormFactorArgs;
use super::destination;
use crate::failure::Failure;
use crate::report::count;
use crate::session::Session;
use azulejo_exchange::{ClusterOptions, Enclosure};

/// Combines rows by `--by` or `--cluster`, if there is one of them.
pub fn grouped(
    enclosure: Enclosure,
    args: &FormFactorArgs,
    session: &mut Session,
) -> Result<Enclosure, Failure> {
    if let Some(by) = args.matrix.by {
        let groups = enclosure.groups(by.into());
        return Ok(session.with_progress(|p| enclosure.gathered(&groups, p))?);
    }
    let Some(cluster_count) = args.matrix.cluster else {
        return Ok(enclosure);
    };
    let options = ClusterOptions {
        count: cluster_count as usize,
        angle: args.matrix.cluster_angle.to_radians(),
        whole_faces: destination::wants_whole_faces(args),
    };
    let clusters = enclosure.clusters(&options);
    let clusters = clusters.map_err(|e| Failure::failed(format_args!("--cluster: {e}")))?;
    let left = clusters.names.len();
    if left > options.count {
        session.note(&format!(
            "--cluster {cluster_count}: {} rows are left: objects, sides, materials, parts that do not touch and \
             bends beyond {}° stay apart, and no cluster closes a ring",
            count(left),
            args.matrix.cluster_angle
        ));
    }
    Ok(session.with_progress(|p| enclosure.gathered(&clusters, p))?)
}

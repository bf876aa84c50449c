//! Light for the texels around charts, which viewers read at the charts' borders.

use crate::layout::NO_CHART;
use crate::lightmap_page::{LightmapPage, mean, neighbours};

/// Continues the light of each chart to this many texels around it.
pub fn pad_charts(page: &mut LightmapPage, rings: u32) {
    for _ in 0..rings {
        add_ring(page);
    }
}

/// Gives every empty texel beside a chart the light of the chart's texels around it.
fn add_ring(page: &mut LightmapPage) {
    let empty: Vec<u32> = (0..page.charts.len() as u32)
        .filter(|&t| page.charts[t as usize] == NO_CHART)
        .collect();
    let mut added = Vec::new();
    for texel in empty {
        let around: Vec<(usize, usize)> = neighbours(page.size, texel)
            .filter(|&(_, n)| page.charts[n] != NO_CHART)
            .collect();
        let Some(&(_, first)) = around.first() else {
            continue;
        };
        let chart = page.charts[first];
        let has_edges = around[0].0 < 4;
        let of_chart: Vec<usize> = around
            .iter()
            .filter(|&&(k, n)| page.charts[n] == chart && (k < 4 || !has_edges))
            .map(|&(_, n)| n)
            .collect();
        added.push((
            texel as usize,
            chart,
            mean(&page.irradiance, &of_chart),
            mean(&page.standard_error, &of_chart),
        ));
    }
    for (texel, chart, irradiance, error) in added {
        page.charts[texel] = chart;
        page.irradiance[texel] = irradiance;
        page.standard_error[texel] = error;
    }
}

/// Fills the texels without a chart, so that smaller copies of the picture (mipmaps) mean something, by
/// push and pull: from the mean of what there is in squares twice as wide, and so on (Gortler et al.,
/// *The lumigraph*, 1996).
pub fn fill(page: &mut LightmapPage) {
    let is_full: Vec<bool> = page.charts.iter().map(|&c| c != NO_CHART).collect();
    if is_full.iter().all(|&f| f) || !is_full.contains(&true) {
        return;
    }
    let weights: Vec<f32> = is_full.iter().map(|&f| f32::from(u8::from(f))).collect();
    pull_push(page.size, &mut page.irradiance, &weights);
    pull_push(page.size, &mut page.standard_error, &weights);
}

fn pull_push(size: [u32; 2], values: &mut [[f32; 3]], weights: &[f32]) {
    if size[0] <= 1 && size[1] <= 1 {
        return;
    }
    let half = size.map(|n| n.div_ceil(2));
    let count = half[0] as usize * half[1] as usize;
    let mut coarse = vec![[0.0f32; 3]; count];
    let mut coarse_weights = vec![0.0f32; count];
    let parent = |t: usize| {
        let (column, row) = (t % size[0] as usize, t / size[0] as usize);
        (row / 2) * half[0] as usize + column / 2
    };
    for (t, (value, &weight)) in values.iter().zip(weights).enumerate() {
        let p = parent(t);
        coarse_weights[p] += weight;
        for (c, v) in coarse[p].iter_mut().zip(value) {
            *c += weight * v;
        }
    }
    for (value, weight) in coarse.iter_mut().zip(&mut coarse_weights) {
        if *weight > 0.0 {
            *value = value.map(|v| v / *weight);
            *weight = weight.min(1.0);
        }
    }
    pull_push(half, &mut coarse, &coarse_weights);
    for (t, (value, &weight)) in values.iter_mut().zip(weights).enumerate() {
        if weight == 0.0 {
            *value = coarse[parent(t)];
        }
    }
}

//! Words of the solver.

use super::Entry;

pub const TABLE: &[Entry] = &[
    ["Engine", "Motor", "Motor"],
    ["Error aimed at", "Error buscado", "Erro pretendido"],
    ["by itself", "automático", "automático"],
    ["rays", "rayos", "raios"],
    ["hemicubes", "hemicubos", "hemicubos"],
    [
        "hemicubes and rays",
        "hemicubos y rayos",
        "hemicubos e raios",
    ],
    ["formulas", "fórmulas", "fórmulas"],
];

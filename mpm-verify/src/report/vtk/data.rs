//! Points and squares with their numbers as data sets. Numbers are written as four bytes: enough for pictures.

use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, PolyDataPiece, UnstructuredGridPiece,
    Version, VertexNumbers, Vtk,
};

/// Numbers of all points or cells under one name.
pub struct Array {
    name: &'static str,
    /// Numbers of one point: 1, 3 of a vector, 9 of a tensor.
    width: usize,
    values: Vec<f32>,
}

impl Array {
    /// One number for each of `all`.
    pub fn scalar<T>(name: &'static str, all: &[T], of: impl Fn(&T) -> f64) -> Self {
        Self { name, width: 1, values: all.iter().map(|one| of(one) as f32).collect() }
    }

    /// A symmetric tensor from its components xx, yy, zz, xy: 3 x 3, row by row, which ParaView shows as XX to ZZ.
    pub fn tensor<T>(name: &'static str, all: &[T], of: impl Fn(&T) -> [f64; 4]) -> Self {
        let rows = |[xx, yy, zz, xy]: [f64; 4]| [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz].map(|v| v as f32);
        Self { name, width: 9, values: all.iter().flat_map(|one| rows(of(one))).collect() }
    }

    /// A vector in the plane for each; the third component is zero.
    pub fn vector<T>(name: &'static str, all: &[T], of: impl Fn(&T) -> [f64; 2]) -> Self {
        Self { name, width: 3, values: all.iter().flat_map(|one| in_space(of(one))).collect() }
    }
}

fn in_space([x, y]: [f64; 2]) -> [f32; 3] {
    [x as f32, y as f32, 0.0]
}

/// Points, each of them a vertex so that it is shown. The first scalar, vector and tensor are the active ones.
pub fn cloud<T>(all: &[T], place: impl Fn(&T) -> [f64; 2], ids: Option<Vec<u32>>, arrays: Vec<Array>) -> Vtk {
    let points: Vec<f32> = all.iter().flat_map(|one| in_space(place(one))).collect();
    let count = all.len() as u64;
    let verts = VertexNumbers::XML { connectivity: (0..count).collect(), offsets: (1..=count).collect() };
    let ids = ids.map(|ids| Attribute::DataArray(DataArray::scalars("id", 1).with_data(ids)));
    let point = attributes(arrays).chain(ids).collect();
    let data = Attributes { point, cell: Vec::new() };
    file(DataSet::inline(PolyDataPiece { points: points.into(), verts: Some(verts), data, ..Default::default() }))
}

/// Squares of edge `size` m, `cells[0]` in a row and `cells[1]` rows, with numbers of the squares. Not an image: the
/// crate reads a flat one back without its numbers, and so could not be tested.
pub fn squares(cells: [usize; 2], size: f64, arrays: Vec<Array>) -> Vtk {
    let corner = |i: usize, j: usize| (j * (cells[0] + 1) + i) as u64;
    let corners = (0..=cells[1]).flat_map(|j| (0..=cells[0]).map(move |i| [i as f64 * size, j as f64 * size]));
    let square = |i: usize, j: usize| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
    let connectivity = (0..cells[1]).flat_map(|j| (0..cells[0]).flat_map(move |i| square(i, j))).collect();
    let count = cells[0] * cells[1];
    let cell_verts = VertexNumbers::XML { connectivity, offsets: (1..=count as u64).map(|k| 4 * k).collect() };
    let points: Vec<f32> = corners.flat_map(in_space).collect();
    let cells = Cells { cell_verts, types: vec![CellType::Quad; count] };
    let data = Attributes { point: Vec::new(), cell: attributes(arrays).collect() };
    file(DataSet::inline(UnstructuredGridPiece { points: points.into(), cells, data }))
}

/// The arrays as attributes. One that the run does not compute, of which no value is a number, is left out.
fn attributes(arrays: Vec<Array>) -> impl Iterator<Item = Attribute> {
    let is_computed = |array: &Array| {
        array.values.is_empty() || array.values.iter().step_by(array.width).any(|first| first.is_finite())
    };
    arrays.into_iter().filter(is_computed).map(|array| {
        let empty = match array.width {
            3 => DataArray::vectors(array.name),
            9 => DataArray::tensors(array.name),
            width => DataArray::scalars(array.name, width as u32),
        };
        Attribute::DataArray(empty.with_data(array.values))
    })
}

fn file(data: DataSet) -> Vtk {
    let version = Version::new_xml(1, 0);
    Vtk { version, title: String::new(), byte_order: ByteOrder::LittleEndian, file_path: None, data }
}

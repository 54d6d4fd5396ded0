//! What launches write.

use std::ops::{Index, IndexMut};

/// Cells in one, two or three dimensions: a launch has one index for each.
#[derive(Clone, Debug, PartialEq)]
pub struct Buffer<T> {
    size: [u32; 3],
    cells: Vec<T>,
}

impl<T: Clone> Buffer<T> {
    /// A line of cells, all alike.
    pub fn line(length: u32, cell: T) -> Self {
        Self::space([length, 1, 1], cell)
    }

    /// Rows of cells: a picture.
    pub fn plane([width, height]: [u32; 2], cell: T) -> Self {
        Self::space([width, height, 1], cell)
    }

    /// Planes of rows of cells.
    pub fn space(size: [u32; 3], cell: T) -> Self {
        let count = size.iter().map(|&side| side as usize).product();
        Self { size, cells: vec![cell; count] }
    }
}

impl<T> Buffer<T> {
    /// Cells along each dimension.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// All cells: the first dimension varies fastest.
    pub fn cells(&self) -> &[T] {
        &self.cells
    }

    /// The same, to be written.
    pub fn cells_mut(&mut self) -> &mut [T] {
        &mut self.cells
    }

    /// All cells.
    pub fn into_cells(self) -> Vec<T> {
        self.cells
    }

    /// The place of a cell among all.
    pub(crate) fn at(size: [u32; 3], [x, y, z]: [u32; 3]) -> usize {
        (z as usize * size[1] as usize + y as usize) * size[0] as usize + x as usize
    }
}

impl<T> Index<[u32; 3]> for Buffer<T> {
    type Output = T;

    /// # Panics
    /// When there is no such cell.
    fn index(&self, index: [u32; 3]) -> &T {
        &self.cells[Self::at(self.size, index)]
    }
}

impl<T> IndexMut<[u32; 3]> for Buffer<T> {
    fn index_mut(&mut self, index: [u32; 3]) -> &mut T {
        &mut self.cells[Self::at(self.size, index)]
    }
}

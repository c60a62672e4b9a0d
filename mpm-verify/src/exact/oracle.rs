//! Reads the tables of `reference-data/exact`, which were computed independently of this code.

/// A table: column names and rows of numbers.
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a table by its file name.
    #[cfg(test)]
    pub fn read(name: &str) -> Self {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/exact").join(name);
        Self::parse(&std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
    }

    /// Reads the text of a table.
    ///
    /// # Panics
    /// It is none: the program carries those it reads, and tests read all of them.
    pub fn parse(text: &str) -> Self {
        let header = text.lines().rfind(|line| line.starts_with("# columns: ")).expect("a line of column names");
        let columns = header["# columns: ".len()..].split(',').map(|name| name.trim().to_owned()).collect();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).has_headers(false).from_reader(text.as_bytes());
        let rows = reader.deserialize().map(|row| row.expect("a row of numbers")).collect();
        Self { columns, rows }
    }

    /// Rows as the values of the named columns.
    pub fn rows<const N: usize>(&self, names: [&str; N]) -> Vec<[f64; N]> {
        let places =
            names.map(|name| self.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}")));
        self.rows.iter().map(|row| places.map(|place| row[place])).collect()
    }
}

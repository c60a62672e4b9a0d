"""Meshes of OpenGeoSys: rectangles of eight nodes, written and read as VTU files."""

import base64
import xml.etree.ElementTree as ElementTree

import numpy as np

SIDES = ("bottom", "right", "top", "left")


class Grid:
    """Rectangles with eight nodes, corners first; rows of a plate, if any, lie above the rows of soil."""

    def __init__(self, xs, ys, soil_rows, axis):
        self.xs, self.ys, self.soil_rows, self.axis = np.array(xs), np.array(ys), soil_rows, axis
        nx, ny = len(xs) - 1, len(ys) - 1
        self.nx, self.ny = nx, ny
        mx, my = (self.xs[1:] + self.xs[:-1]) / 2, (self.ys[1:] + self.ys[:-1]) / 2
        self.centres = np.array([(x, y) for y in my for x in mx])
        self.nodes = np.array([(x, y) for y in self.ys for x in self.xs] + [(x, y) for y in self.ys for x in mx]
                              + [(x, y) for y in my for x in self.xs])
        self.cells = np.array([self.cell(i, j) for j in range(ny) for i in range(nx)])
        self.material = np.zeros(nx * ny, int)

    def cell(self, i, j):
        row, corners = self.nx + 1, (self.nx + 1) * (self.ny + 1)
        flat, upright = corners + j * self.nx + i, corners + self.nx * (self.ny + 1) + j * row + i
        first = j * row + i
        return first, first + 1, first + row + 1, first + row, flat, upright + 1, flat + self.nx, upright

    def edges(self, side):
        """Start, end and middle of the edges of a side, and their cells; `surface` is the top of the soil."""
        index = np.arange(self.nx * self.ny).reshape(self.ny, self.nx)
        cells, at = {"bottom": (index[0], (0, 1, 4)), "right": (index[:, -1], (1, 2, 5)), "top": (index[-1], (3, 2, 6)),
                     "left": (index[:, 0], (0, 3, 7)), "surface": (index[self.soil_rows - 1], (3, 2, 6))}[side]
        return self.cells[cells][:, at], cells

    def write(self, folder):
        vtu(folder / "soil.vtu", self.nodes, self.cells, 23, {}, {"MaterialIDs": ("Int32", self.material)})
        for side in SIDES:
            edges, cells = self.edges(side)
            nodes, local = np.unique(edges, return_inverse=True)
            vtu(folder / f"{side}.vtu", self.nodes[nodes], local.reshape(edges.shape), 21,
                {"bulk_node_ids": ("UInt64", nodes)}, {"bulk_element_ids": ("UInt64", cells)})

    def surface_mean(self, values):
        """Mean over the top of the soil by Simpson's rule; about an axis each place counts by its radius."""
        edges, _ = self.edges("surface")
        x = self.nodes[edges][:, :, 0]
        weight = np.array([1, 1, 4]) * (x[:, 1:2] - x[:, 0:1]) * (x if self.axis else 1.0)
        return (weight * values[edges]).sum() / weight.sum()


def vtu(path, nodes, cells, kind, point_data, cell_data):
    """Writes an unstructured mesh, as text, with its fields: name -> (type, values)."""
    def array(name, type_, values, components=1):
        text = " ".join(repr(v) for v in np.asarray(values).ravel().tolist())
        size = f' NumberOfComponents="{components}"' if components > 1 else ""
        return f'<DataArray type="{type_}" Name="{name}"{size} format="ascii">{text}</DataArray>'
    count, width = cells.shape
    points = np.column_stack([nodes, np.zeros(len(nodes))])
    topology = array("connectivity", "Int64", cells) + array("offsets", "Int64", width * np.arange(1, count + 1))
    fields = ["".join(array(name, *field) for name, field in data.items()) for data in (point_data, cell_data)]
    path.write_text(
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(nodes)}" NumberOfCells="{count}"><PointData>{fields[0]}</PointData>'
        f'<CellData>{fields[1]}</CellData><Points>{array("Points", "Float64", points, 3)}</Points>'
        f'<Cells>{topology}{array("types", "UInt8", np.full(count, kind))}</Cells></Piece></UnstructuredGrid>'
        "</VTKFile>")


def read(path):
    """All fields of a result: name -> values; every array is base64, with its length in front."""
    root, kinds = ElementTree.parse(path).getroot(), {"Float64": "f8", "Int32": "i4", "Int64": "i8", "UInt64": "u8"}
    head = 8 if root.get("header_type") == "UInt64" else 4
    fields = {}
    for array in root.iter("DataArray"):
        if array.get("type") in kinds:
            values = np.frombuffer(base64.b64decode(array.text.strip())[head:], kinds[array.get("type")])
            width = int(array.get("NumberOfComponents", 1))
            fields[array.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return fields

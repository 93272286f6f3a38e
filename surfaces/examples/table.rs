//! The faces of a mesh, a convex part of one of them, and the file they are kept in.

use nalgebra::{Point2, Point3, Vector2};
use surfaces::{TriangleMesh, mesh};

fn main() -> Result<(), surfaces::Error> {
    // A table top around a square opening, 0.7 m above the ground: four corners out, four in.
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corner = |(x, y): (f64, f64), scale: f64| Point3::new(scale * x, scale * y, 0.7);
    let outer = square.map(|xy| corner(xy, 1.0));
    let inner = square.map(|xy| corner(xy, 0.4));
    let side = |i: usize| {
        let j = (i + 1) % 4;
        [[i, j, j + 4], [i, j + 4, i + 4]]
    };
    let table = TriangleMesh {
        vertices: outer.into_iter().chain(inner).collect(),
        triangles: (0..4).flat_map(side).collect(),
    };
    let (terrain, report) = mesh::extract(&table, 0.03)?;
    println!(
        "{} triangles are {} face(s)",
        report.triangles, report.faces
    );

    // Where a hand may be put that wants to be in front of the opening: 5 cm from every edge.
    let top = &terrain.faces[0];
    let room = top.inset_region(2.0, 0.05);
    let wanted = Point2::new(0.0, -0.5);
    if let Some(part) = room.convex_around(&wanted, &Vector2::x()) {
        println!("{}: {:.3} m² around {wanted}", top.id, part.area());
    }
    print!("{}", terrain.to_json()?);
    Ok(())
}

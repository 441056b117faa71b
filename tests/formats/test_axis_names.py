"""Which columns a header names as coordinates."""

from __future__ import annotations

import pytest

from pcsmooth.formats.axis_names import named_axes, named_normals


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("x,y,z", [0, 1, 2]),
        ("Z,Y,X,i", [2, 1, 0]),
        ("x,y,i", [0, 1]),
        ("PointID,Easting,Northing,Elevation", [1, 2, 3]),
        ("P,N,E,Z,D", [2, 1, 3]),
        ("id,E,N,H", [1, 2, 3]),
        ("Scalars_,Points:0,Points:1,Points:2", [1, 2, 3]),
        ("Points_0,Points_1,Points_2,Normals_0", [0, 1, 2]),
        ("Points[0],Points[1],Points[2]", [0, 1, 2]),
        ("time,range,x_m,y_m,z_m", [2, 3, 4]),
        ("x[m],y[m],z[m]", [0, 1, 2]),
        ("X (m),Y (m),Z (m)", [0, 1, 2]),
        ("x/m,y/m,z/m", [0, 1, 2]),
        ("$X$,$Y$,$Z$", [0, 1, 2]),
        ("POINT_X,POINT_Y,POINT_Z", [0, 1, 2]),
        ("X Coord,Y-Coordinate,z.coord", [0, 1, 2]),
        ("position.x,position.y,position.z", [0, 1, 2]),
        ("Easting (m),Northing (m),Ellipsoidal Height [m]", [0, 1, 2]),
        ("Id,Rechtswert,Hochwert,Hoehe", [1, 2, 3]),
        ("Ostwert,Nordwert,HÖHE", [0, 1, 2]),
        ("Est,Nord,Altitude", [0, 1, 2]),
        ("este,norte,elevación", [0, 1, 2]),
        ("Est,Nord,Quota", [0, 1, 2]),
        ("oost,noord,hoogte", [0, 1, 2]),
        ("öst,norr,höjd", [0, 1, 2]),
        ("øst,nord,høyde", [0, 1, 2]),
        ("latitude,longitude,altitude", [1, 0, 2]),
        ("E,N,Depth", [0, 1, 2]),
        ("E,N,U", [0, 1, 2]),
        ("North,East,Up", [1, 0, 2]),
        ("easting_m,northing_m,up_m", [0, 1, 2]),
        ("Rechtswert,Hochwert,Hoehe_NHN", [0, 1, 2]),
        ("Easting,Northing,Height_AHD", [0, 1, 2]),
        ("Easting,Northing,MSL", [0, 1, 2]),
        ("X,Y,H_NN", [0, 1, 2]),
        ("X_UTM,Y_UTM,Cote NGF", [0, 1, 2]),
        ("XValue,Y_value,Zvalue", [0, 1, 2]),
        ("x,y,Elevation (m) NAVD88", [0, 1, 2]),
        ("x,y,u,v", [0, 1]),
        ("E,N,H,U", [0, 1, 2]),
        ("x,y,z,height,depth", [0, 1, 2]),
        ("x,y,z,x_m,y_m,z_m,lon,lat", [0, 1, 2]),
        ("x,y,height", [0, 1, 2]),
        ("a,b,c,d", []),
        ("x,z", []),
        ("vx,vy,vz", []),
        ("x_old,y_old,z_old", []),
        ("sigma_x,sigma_y,sigma_z", []),
        ("nx,ny,nz", []),
        ("xm,ym,zm", []),
        ("", []),
        (f"{'x' * 100_000},y,z", []),
    ],
)
def test_headers(header: str, columns: list[int]) -> None:
    named = named_axes(header.split(","))
    assert [candidates[0] for candidates in named.candidates] == columns
    assert all(len(candidates) == 1 for candidates in named.candidates)


@pytest.mark.parametrize(
    ("header", "candidates"),
    [
        ("x,X,y", ([0, 1], [2])),
        ("x_m,x_ft,y_m,z_m", ([0, 1], [2], [3])),
        ("e,n,height,elevation", ([0], [1], [2, 3])),
    ],
)
def test_rivals(header: str, candidates: tuple[list[int], ...]) -> None:
    assert named_axes(header.split(",")).candidates == candidates


@pytest.mark.parametrize(
    ("header", "in_degrees"),
    [
        ("lon,lat,height", True),
        ("Longitude,Latitude", True),
        ("x [deg],y [deg]", True),
        ("x (°),y (°),z (m)", True),
        ("E,N,H", False),
        ("x [m],y [m]", False),
        ("x,y,lon,lat", False),
    ],
)
def test_degrees(header: str, in_degrees: bool) -> None:
    assert named_axes(header.split(",")).in_degrees == in_degrees


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("x,y,z,nx,ny,nz", (3, 4, 5)),
        ("NormalX,NormalY,NormalZ,x,y,z", (0, 1, 2)),
        ("normal_x,normal_y,normal_z", (0, 1, 2)),
        ("Normals:0,Normals:1,Normals:2", (0, 1, 2)),
        ("nx,ny", ()),
        ("nx,ny,nz,normal_x", ()),
    ],
)
def test_normals(header: str, columns: tuple[int, ...]) -> None:
    assert named_normals(header.split(","), 3) == columns

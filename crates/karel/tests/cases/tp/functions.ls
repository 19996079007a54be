/PROG  FUNCTIONS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  SR[1]='Robot can't move'  ;
   2:  R[1]=STRLEN SR[1] ;
   3:  SR[2]=SUBSTR SR[1],7,R[2] ;
   4:  R[2]=5 ;
   5:  SR[2]=SUBSTR SR[1],7,R[2] ;
   6:  SR[3]=SUBSTR SR[1],15,99 ;
   7:  R[3]=FINDSTR SR[1],SR[2] ;
   8:  R[4]=FINDSTR SR[2],SR[1] ;
   9:  R[5]=(-7) ;
  10:  R[6]=(ABS[R[5]]+1) ;
  11:  R[7]=(SQRT[16]) ;
  12:  R[8]=(SIN[30]) ;
  13:  R[9]=(COS[60]*2) ;
  14:  R[10]=(TAN[45]) ;
  15:  R[11]=(ASIN[1]) ;
  16:  R[12]=(ACOS[0]) ;
  17:  R[13]=(ATAN[1]) ;
  18:  R[14]=(ATAN2[0,2]) ;
  19:  R[15]=(LN[1]+EXP[0]) ;
  20:  R[16]=(ROUND[2.5]) ;
  21:  R[17]=(TRUNC[R[18]]) ;
  22:  R[18]=ABS[R[5]] ;
  23:  R[19]=(SQRT[R[5]]) ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[2:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, -1',
	X = 800.000 mm,	Y = 100.000 mm,	Z = 600.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[3:"never taught"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = ********  mm,	Y = ********  mm,	Z = ********  mm,
	W = ******** deg,	P = ******** deg,	R = ******** deg
};
P[4]{
   GP1:
	UF : F, UT : F,
	J1 = ******** deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
